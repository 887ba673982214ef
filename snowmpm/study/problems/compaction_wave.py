"""The exact plastic wave that a piston drives into snow at rest (M10), from the differential equations of its law.

Uniaxial strain e = 1 - F under the nominal stress P(e). With x = -ln F, p0 = K sinh(xi z) and the yield surface
y = q^2 (1 + 2 beta) + M^2 (p + beta p0) (p - p0) of cohesive Cam-Clay, once y = 0:

    dp = K (1 - g y_p) dx,   dq = 3 G (2/3 - g y_q) dx,   dz = g y_p dx,   P = (p + 2 q / 3) / F
    g = (K y_p + 2 G y_q) / (K y_p^2 + 3 G y_q^2 - y_p0 p0' y_p)

The wave is self-similar: up to its final strain e1 it follows the upper concave hull of P(e), at the Lagrangian speeds
sqrt(P' / rho0) of its parts. Where the hull leaves P(e) it is the chord of a shock, of speed D. Piston speed V = the
integral of sqrt(hull' / rho0) de.
"""

from dataclasses import dataclass

import numpy as np

STRONGEST = 0.7
"""Largest strain e of the table of P(e)."""


@dataclass(frozen=True)
class Front:
    """speed: D of the shock [m/s]; stress: P1 [Pa]; density: rho1 [kg/m3]; foot: P ahead of the shock [Pa]."""

    speed: float
    stress: float
    density: float
    foot: float


def oedometric_path(law):
    """e and P(e) [Pa], elastic part and plastic one."""
    K, G, M2, beta = law.bulk_modulus, law.shear_modulus, law.critical_slope**2, law.cohesion

    def value(p, q, p0):
        return q**2 * (1 + 2 * beta) + M2 * (p + beta * p0) * (p - p0)

    def rates(x, state):
        p, q, z = state
        p0, slope = K * np.sinh(law.hardening * z), K * law.hardening * np.cosh(law.hardening * z)
        y_p, y_q, y_p0 = M2 * (2 * p - (1 - beta) * p0), 2 * (1 + 2 * beta) * q, M2 * ((beta - 1) * p - 2 * beta * p0)
        g = (K * y_p + 2 * G * y_q) / (K * y_p**2 + 3 * G * y_q**2 - y_p0 * slope * y_p)
        return [K * (1 - g * y_p), 3 * G * (2 / 3 - g * y_q), g * y_p]

    from scipy.integrate import solve_ivp  # slow to import
    from scipy.optimize import brentq

    at_yield = brentq(lambda x: value(K * x, 2 * G * x, law.p0), 1e-9, 2 * law.p0 / K)
    start = [K * at_yield, 2 * G * at_yield, np.arcsinh(law.p0 / K) / law.hardening]
    end = -np.log1p(-STRONGEST)
    plastic = solve_ivp(rates, (at_yield, end), start, method="DOP853", rtol=1e-11, atol=1e-9, dense_output=True).sol
    x = at_yield + np.concatenate([np.geomspace(1e-7, 1e-2, 2000), np.linspace(1e-2, end - at_yield, 20_000)[1:]])
    p, q, _ = plastic(x)
    x, axial = np.append([0.0, at_yield], x), np.append([0.0, (K + 4 / 3 * G) * at_yield], p + 2 / 3 * q)
    return -np.expm1(-x), axial * np.exp(x)


def front(law, speed):
    """`Front` of a piston of `speed` [m/s]."""
    e, P = oedometric_path(law)

    def hull(end):
        """Corners of the upper concave hull of the first `end` points, and the speeds of its parts."""
        corners = []
        for k in range(end):
            while len(corners) > 1 and ((P[corners[-1]] - P[corners[-2]]) * (e[k] - e[corners[-1]])
                                        <= (P[k] - P[corners[-1]]) * (e[corners[-1]] - e[corners[-2]])):
                corners.pop()
            corners.append(k)
        return corners, np.sqrt(np.diff(P[corners]) / np.diff(e[corners]) / law.density)

    low, high = 3, len(e)
    while high - low > 1:
        middle = (low + high) // 2
        corners, speeds = hull(middle)
        low, high = (middle, high) if speeds @ np.diff(e[corners]) < speed else (low, middle)
    corners, speeds = hull(high)
    assert high < len(e), "the strain lies beyond the table"
    return Front(float(speeds[-1]), float(P[high - 1]), float(law.density / (1.0 - e[high - 1])),
                 float(P[corners[-2]]))
