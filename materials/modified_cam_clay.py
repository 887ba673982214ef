"""Modified Cam-Clay: the cohesionless critical-state law."""

from typing import Literal

from .critical_state import CriticalStateLaw


class ModifiedCamClay(CriticalStateLaw):
    """Modified Cam-Clay (Roscoe & Burland 1968): the cohesionless critical-state law, `CohesiveCamClay` with β = 0.

        y(p, q) = q² + M² p (p − p₀) <= 0,   p₀ = K sinh(ξ max(z, 0)),   z = −ln det Fp

    No tension: the ellipse passes through the origin. Critical state: p = p₀/2, q = M p.
    hardening_law "exponential" is the classical law of clays, p₀ = p₀(0) exp(ξ Δz), with ξ = 1 / (λ* − κ*) of the
    compression and swelling indices in ln J; the default is the sinh law of [G 57] (`CohesiveCamClay`). Keys of a
    scene: M `critical_slope`, ξ `hardening`, p₀ at the start `p0`; K from `youngs_modulus` and `poisson_ratio`.
    """

    kind: Literal["modified_cam_clay"] = "modified_cam_clay"
