"""Material without tensile strength that is pulled apart: the gap that opened must close before stress comes back.

A cohesionless cone has its apex at p = 0. Plastic dilation there is not dilatancy, it is grains losing touch, and a law
that forgets it grows: pulled apart and pushed back to its old volume, it would press outward with that dilation
(Tampubolon et al. 2017, doi:10.1145/3072959.3073651, section 4.3.4). So the opened volume is a state variable,
the gap g >= 0, a logarithmic volume strain as ln det f adds up:

    separated, stress-free while g > 0;   opening and closing: dg = d(ln det f),   no work in either

While grains do not touch, shear costs nothing and dilates nothing.
"""

from snowmpm.compiler import ti

from .law import StateVariable

GAP = StateVariable("gap", "-", "opened volume of separated material, ln of the volume ratio; > 0 stress-free")


@ti.func
def close_gap(p_trial, gap, bulk):
    """p [Pa] of the trial state behind the gap, the share of the step behind it, and what is left of the gap.

    Separated material starts from h = 0, so a step through the gap has loaded nothing until p_trial = K g. The share
    behind it is exact for a step of constant direction, which is all that is known of a step. 0: still separated.
    """
    p, share, left = p_trial, 1.0, 0.0
    if gap > 0.0:
        p = ti.max(p_trial - bulk * gap, 0.0)
        # Either a stress or a gap, never both by rounding
        left = ti.select(p > 0.0, 0.0, ti.max(gap - p_trial / bulk, 0.0))
        share = ti.select(p > 0.0, p / ti.max(p_trial, p), 0.0)
    return p, share, left


@ti.func
def trial_behind_gap(trial: ti.template(), h, A, bulk, gap):
    """Trial state of a law with a gap: h, deviator e of the whole step, e : e, p [Pa] and share behind the gap, what is
    left of the gap, and 1 if the step could be made, else 0; the gap then stays. trial: like `elastic_trial`."""
    h_new, deviator, volume, deviator2, valid = trial(h, A)
    p, share, left = close_gap(-bulk * volume, ti.select(valid == 1, gap, 0.0), bulk)
    return h_new, deviator, deviator2, p, share, ti.select(valid == 1, left, gap), valid
