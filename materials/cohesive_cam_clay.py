"""Cohesive Cam-Clay: snow that hardens when compacted and softens, to complete separation, when it dilates."""

from typing import Annotated, ClassVar, Literal

import taichi as ti
from pydantic import Field

from .critical_state import CriticalStateLaw
from .elastic import elastic_trial
from .ellipse import YIELD_TOLERANCE, return_to_ellipse, sinh_cosh
from .hencky import deviation_of_strain
from .law import StateVariable
from .precision import by_precision
from .symmetric import plus_isotropic


@ti.func
def cohesive_cam_clay_update(prm, h, state, A, dt):
    """See `Law`. prm: `CriticalStateLaw.ellipse_parameters`; state: z."""
    K, G, xi, beta, p_fixed = prm[0], prm[1], prm[2], prm[3], prm[4]
    h_new, deviator, volume, deviator2, valid = elastic_trial(h, A)
    z = state[0]
    p = -K * volume
    e2 = (1.0 + 2.0 * beta) * prm[6] * deviator2
    s, c = sinh_cosh(xi * z)
    p0 = p_fixed + K * s
    w = p - 0.5 * (1.0 - beta) * p0
    radius = 0.5 * (1.0 + beta) * p0
    state_new = state
    dissipation = 0.0
    iterations = valid - 1
    if w * w + e2 > radius * radius * ti.static(1.0 + by_precision(*YIELD_TOLERANCE)):
        p_trial, ratio = p, 0.0
        if p_fixed == 0.0 and p + K * z <= 0.0:
            # Dilates until p₀ = 0 and beyond: the ellipse is a point, the snow is separated and stress-free
            p = 0.0
            h_new.fill(0.0)
        else:
            start, end = 0.0, w / K
            if p_fixed == 0.0:
                if w > 0.0:
                    start = ti.max(0.0, -z)  # separated snow first closes its gap, without stress
                else:
                    end = ti.max(end, -z)
            side = 1.0 if w > 0.0 else -1.0
            p, ratio, iterations = return_to_ellipse(
                p_trial, e2, K, (1.0 + 2.0 * beta) * prm[5], xi, beta, p_fixed, z, 1.0, s, c, side, start, end
            )
            h_new = deviation_of_strain(ratio * deviator, -p / K, ratio * ratio * deviator2)
        compaction = (p_trial - p) / K
        state_new[0] = z + compaction
        dissipation = 0.5 * (p_trial + p) * compaction + G * deviator2 * (1.0 - ratio * ratio)
        deviator *= ratio
    tau = plus_isotropic(2.0 * G * deviator, -p)
    return h_new, tau, state_new, dissipation, iterations


class CohesiveCamClay(CriticalStateLaw):
    """Cohesive Cam-Clay with associated flow and volumetric hardening, on Hencky elasticity.

        y(p, q) = q² (1 + 2β) + M² (p + β p₀)(p − p₀) <= 0                 [G 56]
        p₀ = K sinh(ξ max(z, 0)),  z = −ε_v^p = −ln det Fp                  [G 57]

    [G] Gaume et al., "Modeling snow and avalanches with the Material Point Method and finite strain elastoplasticity";
    the surface is that of Gaume et al. (2018), doi:10.1038/s41467-018-05181-w. An initial p₀ fixes
    z₀ = asinh(p₀/K)/ξ. Compaction hardens; dilation softens until p₀ = 0 at z = 0, where the snow is separated:
    stress-free while z <= 0, so a gap that opened must close before stress comes back. Critical state:
    p = (1 − β) p₀/2.
    Backward Euler, hardening included (see `ellipse.py`): admissible at the updated p₀ for a step of any size.

    Deviation: [G 54] divides the trace by the dimension of the problem; here p is −tr(τ)/3 in plane strain as well.
    Validity: under strain control the softening branch is unique while βξ cosh(ξ z₀) < 1 (sharper for small β). Above,
    a step may jump to the separated state and the energy dissipated depends on the step.
    """

    STATE: ClassVar[tuple[StateVariable, ...]] = (
        StateVariable("compaction", "-", "z = −ln det Fp, the plastic compaction that sets p0; <= 0 separated"),
    )
    kind: Literal["cohesive_cam_clay"] = "cohesive_cam_clay"
    cohesion: Annotated[float, Field(ge=0.0, le=1.0)]  # β [-]

    update = staticmethod(cohesive_cam_clay_update)

    @property
    def beta(self):
        return self.cohesion

    def parameters(self):
        return self.ellipse_parameters()

    def initial_state(self):
        return (self.initial_zeta,)

    def severed_state(self):
        return (0.0,) if self.hardening > 0.0 else None
