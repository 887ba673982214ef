"""Circular cones that stand for a Coulomb friction angle: their slope, and the angle back from it.

    q = α (p + c cot φ)        Coulomb: |τ| = c + σ_n tan φ

A circle in the deviatoric plane can touch Mohr-Coulomb's hexagon in one way only, so the same friction angle gives
different slopes α (sandy φ = 37°: 1.51, 1.00, 1.04). s = sin φ, p and q three-dimensional:

    triaxial_compression   α = 6 s / (3 − s)      outer corners: σ₂ = σ₃ (compression positive, σ₁ >= σ₂ >= σ₃)
    triaxial_extension     α = 6 s / (3 + s)      inner corners: σ₁ = σ₂
    plane_strain           α = s / (r + s α_ψ/9), r = √((1 − α_ψ²/9)/3), α_ψ = 3 sin ψ / √(3 + sin²ψ)
                           same limit load in plane strain: √3 s for ψ = 0, 3√3 tan φ/√(9 + 12 tan²φ) for ψ = φ

The first two: e.g. de Souza Neto, Perić & Owen, Computational Methods for Plasticity (2008), section 6.4.4, which
also has ψ = φ of the third. In between from the flow rule at the limit state, where no plastic strain is left along
the third axis: s_zz = −(2/9) α_ψ q (so does the Abaqus manual, extended Drucker-Prager models).
α_ψ is the slope of dilation: plastic volume growth over plastic shear strain ε_s, in the matching of the same name.
"""

from typing import Literal, get_args

import numpy as np

Cone = Literal["triaxial_compression", "triaxial_extension", "plane_strain"]
CONES = get_args(Cone)


def dilation_slope(dilation_angle, cone):
    """α_ψ [-] of a dilation angle ψ [deg]."""
    s = np.sin(np.radians(dilation_angle))
    return 3.0 * s / np.sqrt(3.0 + s * s) if cone == "plane_strain" else _triaxial_slope(s, cone)


def cone_slope(friction_angle, cone, dilation_angle=0.0):
    """α = q / (p + c cot φ) [-] of a friction angle φ [deg]; ψ [deg] matters in plane strain alone."""
    s = np.sin(np.radians(friction_angle))
    if cone != "plane_strain":
        return _triaxial_slope(s, cone)
    along = dilation_slope(dilation_angle, cone) / 9.0
    return s / (np.sqrt(1.0 / 3.0 - 3.0 * along * along) + s * along)


def cone_friction_angle(slope, cone, dilation_angle=0.0):
    """φ [deg] whose cone has the slope α [-]. Raises ValueError where no Coulomb angle is that strong."""
    if cone == "plane_strain":
        along = dilation_slope(dilation_angle, cone) / 9.0
        s = slope * np.sqrt(1.0 / 3.0 - 3.0 * along * along) / (1.0 - slope * along)
    else:
        s = 3.0 * slope / (6.0 + _side(cone) * slope)
    if np.any(np.asarray(s) < 0.0) or np.any(np.asarray(s) >= 1.0):
        raise ValueError(f"no friction angle below 90 degrees has a {cone} cone of slope {slope}")
    return np.degrees(np.arcsin(s))


def _triaxial_slope(s, cone):
    return 6.0 * s / (3.0 - _side(cone) * s)


def _side(cone):
    """+1 at the corners of compression, −1 at those of extension."""
    return {"triaxial_compression": 1.0, "triaxial_extension": -1.0}[cone]
