"""Converters between this library's conventions and those of textbooks and other programs; see CONVENTIONS.md.

Here: Kirchhoff stress, tension positive; p = −tr(τ)/3, compression positive; q = √(3/2 s:s) = √(3 J₂); all
three-dimensional, in plane strain too. Angles in degrees, stresses in pascals. NumPy; arrays broadcast.
"""

import numpy as np

from .cone import cone_friction_angle, cone_slope


def tensile_apex(cohesion, friction_angle):
    """Isotropic tension c cot φ [Pa] at which Coulomb's line ends: what "cohesion" fixes in every law here."""
    return cohesion / np.tan(np.radians(friction_angle))


def cohesion_of_apex(apex, friction_angle):
    """Coulomb's c [Pa] of a tensile apex [Pa]."""
    return apex * np.tan(np.radians(friction_angle))


def cohesion_ratio(cohesion, friction_angle, p0):
    """β of `CohesiveCamClay` with preconsolidation p₀ [Pa] whose tensile apex, β p₀, is c cot φ."""
    return tensile_apex(cohesion, friction_angle) / p0


def drucker_prager_of_coulomb(cohesion, friction_angle, cone, dilation_angle=0.0):
    """(α, k [Pa]) of q = α p + k from Coulomb's c [Pa] and φ, with the same tensile apex."""
    alpha = cone_slope(friction_angle, cone, dilation_angle)
    return alpha, alpha * tensile_apex(cohesion, friction_angle)


def coulomb_of_drucker_prager(alpha, k, cone, dilation_angle=0.0):
    """(c [Pa], φ) from α and k [Pa] of q = α p + k. ValueError where α is steeper than any angle."""
    angle = cone_friction_angle(alpha, cone, dilation_angle)
    return cohesion_of_apex(k / alpha, angle), angle


def critical_slope(friction_angle, cone="triaxial_compression"):
    """Critical-state slope M = q/p of Cam-Clay from the critical friction angle: the slope of the cone without c."""
    return cone_slope(friction_angle, cone)


def critical_friction_angle(slope, cone="triaxial_compression"):
    """The inverse of `critical_slope`."""
    return cone_friction_angle(slope, cone)


def equivalent_friction_angle(friction_angle, cone, loading):
    """Friction angle that a cone matched to φ in one way shows when loaded in another, both names of cones.

    ValueError where the cone is steeper than any Coulomb material under that loading.
    """
    return cone_friction_angle(cone_slope(friction_angle, cone), loading)


def drucker_prager_of_j2(alpha_i1, k_j2):
    """(α, k [Pa]) from f = α_I I₁ + √J₂ − k_J, tension positive (Drucker & Prager; most SPH codes)."""
    return 3.0 * np.sqrt(3.0) * alpha_i1, np.sqrt(3.0) * k_j2


def drucker_prager_of_tangent(beta, d):
    """(α, k [Pa]) from t − p tan β − d, β in degrees, with t = q (the circular cone, K = 1, of Abaqus)."""
    return np.tan(np.radians(beta)), d


def drucker_prager_of_log_strain(alpha_log):
    """α from ‖dev ε‖ + α_s tr(ε) (3λ + 2μ)/(2μ) <= 0 on Hencky strain, sand of Klár et al. (2016), in 3-D.

    doi:10.1145/2897824.2925906; its α_s = √(2/3) 2 sin φ/(3 − sin φ) is the triaxial compression cone.
    """
    return 1.5 * np.sqrt(6.0) * alpha_log


def friction_angle_of_plane_invariants(slope):
    """Friction angle in the plane of a program whose p₂ = −(τ₁₁ + τ₂₂)/2 and q₂ = √(3/2 s₂:s₂) are two-dimensional.

    q₂ is √3 times the radius of Mohr's circle, so the slope q₂/p₂ is √3 sin φ, whatever stands normal to the plane: the
    same number as α of the plane strain cone without dilation. ValueError beyond √3.
    """
    return cone_friction_angle(slope, "plane_strain")


def bulk_modulus_of_plane(bulk_modulus, shear_modulus):
    """K₂ = λ + μ [Pa], which two-dimensional invariants use for K (p₂ = −K₂ tr ε, p₀ = K₂ sinh(ξ z))."""
    return bulk_modulus + shear_modulus / 3.0


def critical_slope_of_bare_ellipse(slope, beta):
    """M here of M' in a program without the factor (1 + 2β): q² + M'² (p + β p₀)(p − p₀) <= 0."""
    return slope * np.sqrt(1.0 + 2.0 * beta)


def invariant_of_shear(tau):
    """q [Pa] of a shear stress invariant |τ| = √J₂ = √(s:s/2) [Pa]: in pure shear |τ| is the shear stress."""
    return np.sqrt(3.0) * tau


def shear_rate_of_invariant(strain_rate):
    """γ̇ = √(2 D:D) from dε_s/dt = √(2/3 D:D), D deviatoric: in simple shear γ̇ is the shear rate."""
    return np.sqrt(3.0) * strain_rate
