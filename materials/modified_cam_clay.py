"""Modified Cam-Clay: the cohesionless critical-state law."""

from typing import ClassVar, Literal

from .cohesive_cam_clay import cohesive_cam_clay_update
from .critical_state import CriticalStateLaw
from .law import StateVariable


class ModifiedCamClay(CriticalStateLaw):
    """Modified Cam-Clay (Roscoe & Burland 1968) with the finite-strain hardening of `CohesiveCamClay`, β = 0:

        y(p, q) = q² + M² p (p − p₀) <= 0,   p₀ = K sinh(ξ max(z, 0)),   z = −ln det Fp

    No tension: the ellipse passes through the origin. Critical state: p = p₀/2, q = M p.
    Deviation: p₀ follows the sinh law of [G 57], not the exponential of the compression index.
    """

    STATE: ClassVar[tuple[StateVariable, ...]] = (
        StateVariable("compaction", "-", "z = −ln det Fp, the plastic compaction that sets p0; <= 0 separated"),
    )
    kind: Literal["modified_cam_clay"] = "modified_cam_clay"

    update = staticmethod(cohesive_cam_clay_update)

    def parameters(self):
        return self.ellipse_parameters()

    def initial_state(self):
        return (self.initial_zeta,)

    def severed_state(self):
        return (0.0,) if self.hardening > 0.0 else None
