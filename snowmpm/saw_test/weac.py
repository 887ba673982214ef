"""Critical length by WEAC, a Timoshenko beam on an elastic weak layer, where it is installed.

Rosendahl & Weissgraeber (2020), doi:10.5194/tc-14-115-2020; the package `weac`, version 2. It knows no strength: the
crack is taken to run when the energy release rate comes to the work of collapse.
"""

import math

from snowmpm.saw_test.prediction import column_of

LONGEST = 0.9
"""Of the column: the longest cut that is tried."""

TRIES = 30
"""Halvings of the interval that the critical length lies in."""


def critical_length(scene, energy):
    """[m], for a work of collapse [J/m2]; None without the package, or where no cut in the column is enough.

    A slab of several layers enters by its mean density and the modulus that gives the same stiffness in bending.
    """
    try:
        import weac
    except ImportError:
        return None
    if not hasattr(weac, "Layered"):
        return None
    slab, law, thickness = column_of(scene)
    ratio = scene.materials[scene.saw_test.slab[0].material].poisson_ratio
    model = weac.Layered(system="pst-", touchdown=False)
    model.set_foundation_properties(t=1e3 * thickness, E=1e-6 * law.youngs_modulus, nu=law.poisson_ratio, update=False)
    # Its modulus is C0 (density / 917)^C1 [GPa]; lengths are in mm
    model.set_beam_properties([[slab.density, 1e3 * slab.thickness]],
                              C0=1e-9 * slab.bending_modulus * (1.0 - ratio**2), C1=0.0, nu=ratio, update=True)
    angle = -scene.saw_test.slope_angle  # it cuts from the right and counts against the clock

    def release_rate(cut):
        parts = model.calc_segments(L=1e3 * scene.saw_test.length, a=1e3 * cut, m=0, phi=angle)["crack"]
        lengths = {name: parts[name] for name in ("li", "ki")}
        solved = model.assemble_and_solve(phi=angle, mi=parts["mi"], **lengths)
        return 1e3 * model.gdif(solved, angle, **lengths)[0]

    lower, upper = 0.0, LONGEST * scene.saw_test.length
    if not release_rate(upper) > energy:
        return None
    for _ in range(TRIES):
        middle = 0.5 * (lower + upper)
        lower, upper = (lower, middle) if release_rate(middle) > energy else (middle, upper)
    return upper if math.isfinite(upper) else None
