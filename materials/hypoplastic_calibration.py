"""From a drained triaxial compression test to the four coefficients of a hypoplastic law, and the check that it works.

One test at the confining pressure σ₃ gives, with R = σ₁/σ₃ and tension positive,

    E_i = initial slope of σ₁ − σ₃ over the axial strain,   ν_i = −(lateral / axial) strain rate there
    R_f = (1 + sin φ)/(1 − sin φ), the largest R,           ν_f = the strain rate ratio there = (1 + tan ψ)/2

Peng, Wu, Yu, Wang (2015), doi:10.1007/s11440-015-0399-3, eqs. 17-18 [P]. "No lateral stress rate at R = 1, no stress
rate at R_f" are four linear equations in the coefficients; they reproduce every number of Table 1 of [P]. They do not
guarantee that a test gets there: for some angles the path stops at a smaller R. `triaxial_failure` follows it.
"""

import numpy as np


def stress_ratio(friction_angle):
    """R_f = σ₁/σ₃ at failure in triaxial compression; friction angle [deg]."""
    sine = np.sin(np.radians(friction_angle))
    return (1.0 + sine) / (1.0 - sine)


def triaxial_rate(terms, coefficients, R, nu):
    """Stress rates (axial, lateral) over σ₃ per unit of axial compression, at σ₁ = R σ₃, lateral strain rate ν.

    terms(stress, rate) -> (..., 3, 4): the four terms of a law for principal stresses and strain rates (..., 3), each
    to be multiplied by its coefficient. Compression positive in the result.
    """
    R, nu = np.broadcast_arrays(np.asarray(R, float), np.asarray(nu, float))
    stress = -np.stack([R, np.ones_like(R), np.ones_like(R)], axis=-1)
    rate = np.stack([-np.ones_like(R), nu, nu], axis=-1)
    return -(terms(stress, rate) @ np.asarray(coefficients, float))[..., :2]


def coefficients(terms, stiffness, nu_i, friction_angle, dilation_angle):
    """The four coefficients; stiffness: E_i over the confining pressure."""
    nu_f = 0.5 * (1.0 + np.tan(np.radians(dilation_angle)))
    initial = np.array([triaxial_rate(terms, unit, 1.0, nu_i) for unit in np.eye(4)]).T
    failure = np.array([triaxial_rate(terms, unit, stress_ratio(friction_angle), nu_f) for unit in np.eye(4)]).T
    return np.linalg.solve(np.vstack([initial, failure]), [stiffness, 0.0, 0.0, 0.0])


def lateral_rate(terms, coefficients, R):
    """Lateral strain rate ν, per unit of axial compression, that keeps σ₃ at σ₁ = R σ₃ (NaN where none does)."""

    # The lateral stress rate is a + b ν + c √(1 + 2 ν²): fit it exactly, then solve the quadratic
    def lateral(nu):
        return triaxial_rate(terms, coefficients, R, nu)[..., 1]

    root3 = np.sqrt(3.0)
    zero, plus, minus = lateral(0.0), lateral(1.0), lateral(-1.0)
    b, even = 0.5 * (plus - minus), 0.5 * (plus + minus)
    c = (even - zero) / (root3 - 1.0)
    a = zero - c
    A, B, C = b * b - 2.0 * c * c, a * b, a * a - c * c
    with np.errstate(invalid="ignore", divide="ignore"):
        root = np.sqrt(B * B - A * C)
        candidates = np.stack([(-B + root) / A, (-B - root) / A])
    residual = np.abs(a + b * candidates + c * np.sqrt(1.0 + 2.0 * candidates**2))
    good = residual <= 1e-9 * (np.abs(a) + np.abs(b) + np.abs(c)) * (1.0 + np.abs(candidates))
    # Two solutions: the one nearer to no volume change
    distance = np.where(good, np.abs(candidates - 0.5), np.inf)
    best = np.where(distance[0] <= distance[1], candidates[0], candidates[1])
    return np.where(np.isfinite(distance.min(axis=0)), best, np.nan)


def triaxial_failure(terms, coefficients, highest, samples=4001):
    """Largest R that drained triaxial compression from R = 1 reaches, looked for up to `highest`; inf beyond it.

    dR/dε is a function of R alone (the law is homogeneous in stress), so the path stops where it first vanishes.
    """

    def growth(R):
        return triaxial_rate(terms, coefficients, R, lateral_rate(terms, coefficients, R))[..., 0]

    R = np.linspace(1.0, highest, samples)
    stopped = np.flatnonzero(~(growth(R) > 0.0))
    if not len(stopped):
        return np.inf
    below, above = R[max(stopped[0] - 1, 0)], R[stopped[0]]
    for _ in range(50):  # halvings: to the last digit
        middle = 0.5 * (below + above)
        below, above = (middle, above) if growth(middle) > 0.0 else (below, middle)
    return float(below)
