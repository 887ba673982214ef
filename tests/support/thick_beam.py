"""A beam that bends far, shears and stretches under a load of fixed direction: Reissner 1972, doi:10.1007/BF01602645.

Along the beam's length s, with the resultants N along the section's normal, Q across it and M:

    x' = lambda cos(theta) - Q / (k G A) sin(theta),   y' = lambda sin(theta) + Q / (k G A) cos(theta),   theta' = kappa
    M' = -(x' F_y - y' F_x) - m

of a cantilever that bears w per length downwards, F_y = -w (L - s); its width is one. A load on its upper face acts
half a thickness beside the middle line, at a point that turns with the section: m = arm w sin(theta). nu = 0.
"""

import numpy as np
from scipy.integrate import solve_bvp

SHEAR_FACTOR = 5.0 / 6.0


def tip(load, length, thickness, youngs_modulus, arm=0.0, hencky=True):
    """End of the middle line (2,) [m], which lies at (length, 0) without load.

    load: per length [N/m]; arm: of the load from the middle line [m]. hencky: fibres with Kirchhoff stress
    E ln(stretch), or of a linear law, N = E A (lambda - 1), M = E I kappa.
    """
    place, weight = np.polynomial.legendre.leggauss(12)
    z, dz = 0.5 * thickness * place, 0.5 * thickness * weight
    area, inertia, shear = thickness, thickness**3 / 12.0, 0.5 * youngs_modulus

    def section(N, M):
        """Stretch of the middle line and curvature, by Newton's method over the fibres."""
        stretch, curvature = 1.0 + N / (youngs_modulus * area), M / (youngs_modulus * inertia)
        for _ in range(20 if hencky else 0):
            fibre = stretch[:, None] + curvature[:, None] * z
            stress = youngs_modulus * np.log(fibre) / fibre
            slope = youngs_modulus * (1.0 - np.log(fibre)) / fibre**2
            off_n, off_m = (stress * dz).sum(1) - N, (stress * dz * z).sum(1) - M
            a, b, c = ((slope * dz * z**i).sum(1) for i in range(3))
            stretch = stretch - (c * off_n - b * off_m) / (a * c - b * b)
            curvature = curvature - (a * off_m - b * off_n) / (a * c - b * b)
        return stretch, curvature

    def rates(s, y):
        _, _, angle, M = y
        F = -load * (length - s)
        stretch, curvature = section(F * np.sin(angle), M)
        slip = F * np.cos(angle) / (SHEAR_FACTOR * shear * area)
        along = stretch * np.cos(angle) - slip * np.sin(angle)
        across = stretch * np.sin(angle) + slip * np.cos(angle)
        return np.array([along, across, curvature, -along * F - arm * load * np.sin(angle)])

    s = np.linspace(0.0, length, 101)
    found = solve_bvp(rates, lambda start, end: np.array([*start[:3], end[3]]), s, np.array([s, 0 * s, 0 * s, 0 * s]),
                      tol=1e-8)
    assert found.success, found.message
    return found.y[:2, -1]
