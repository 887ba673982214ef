"""Cohesive Cam-Clay: snow that hardens when compacted and softens, to complete separation, when it dilates."""

from typing import Annotated, Literal

from pydantic import Field

from .critical_state import CriticalStateLaw


class CohesiveCamClay(CriticalStateLaw):
    """Cohesive Cam-Clay with associated flow and volumetric hardening, on Hencky elasticity.

        y(p, q) = q² (1 + 2β) + M² (p + β p₀)(p − p₀) <= 0                 [G 56]
        p₀ = K sinh(ξ max(z, 0)),  z = −ε_v^p = −ln det Fp                  [G 57]

    [G] Gaume et al., "Modeling snow and avalanches with the Material Point Method and finite strain elastoplasticity";
    the surface is that of Gaume, Gast, Teran, van Herwijnen and Jiang (2018), Nature Communications 9, 3047,
    doi:10.1038/s41467-018-05181-w. Keys of a scene: M `critical_slope`, β `cohesion`, ξ `hardening`, p₀ at the start
    `p0`; K from `youngs_modulus` and `poisson_ratio`. An initial p₀ fixes z₀ = asinh(p₀/K)/ξ.
    Compaction hardens; dilation softens until p₀ = 0 at z = 0, where the snow is separated:
    stress-free while z <= 0, so a gap that opened must close before stress comes back. Critical state:
    p = (1 − β) p₀/2.
    Backward Euler, hardening included (see `ellipse.py`): admissible at the updated p₀ for a step of any size.

    Deviation: [G 54] divides the trace by the dimension of the problem; here p is −tr(τ)/3 in plane strain as well.
    Validity: under strain control the softening branch is unique while βξ cosh(ξ z₀) < 1 (sharper for small β). Above,
    a step may jump to the separated state and the energy dissipated depends on the step.
    """

    kind: Literal["cohesive_cam_clay"] = "cohesive_cam_clay"
    cohesion: Annotated[float, Field(ge=0.0, le=1.0)]
    """β: isotropic tensile over compressive strength [-]"""

    @property
    def beta(self) -> float:
        return self.cohesion
