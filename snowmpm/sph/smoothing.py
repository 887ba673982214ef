"""Smoothing kernels W(r) of compact support: of radius H = 2 h, the Gaussian of 3 h.

    W = N / H^d w(s),   (1/r) dW/dr = N / H^(d + 2) slope(s),   s = r / H,  t = 1 - s

with N such that W integrates to 1 over the plane (d = 2) or space (d = 3). Wendland's (1995) C2, C4 and C6 have a
positive Fourier transform, and so never pair under compression (Dehnen & Aly 2012,
doi:10.1111/j.1365-2966.2012.21439.x); the cubic spline (Monaghan & Lattanzio 1985) needs fewer neighbours. The Gaussian
(Gingold & Monaghan 1977, doi:10.1093/mnras/181.3.375), exp(-r^2 / h^2), is cut where it has fallen to 1e-4, and lowered
by that.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from snowmpm.compiler import ti


def _c2(s, t):
    return t**4 * (1.0 + 4.0 * s)


def _c2_slope(s, t):
    return -20.0 * t**3


def _c4(s, t):
    return t**6 * (1.0 + s * (6.0 + s * (35.0 / 3.0)))


def _c4_slope(s, t):
    return -(56.0 / 3.0) * t**5 * (1.0 + 5.0 * s)


def _c6(s, t):
    return t**8 * (1.0 + s * (8.0 + s * (25.0 + s * 32.0)))


def _c6_slope(s, t):
    return -22.0 * t**7 * (1.0 + s * (7.0 + s * 16.0))


def _cubic(s, t):
    u = 1.0 - 2.0 * s
    inner = 0.5 * (u + abs(u))
    return 2.0 * t**3 - inner**3


def _cubic_slope(s, t):
    u = 1.0 - 2.0 * s
    inner = 0.5 * (u + abs(u))
    return -6.0 * (t**2 - inner**2) / (s + 1e-9)


CUT = math.exp(-9.0)
"""Of the Gaussian at 3 h, over its middle."""


def _gaussian(s, t):
    return (CUT ** (s * s) - CUT) * (t / (t + 1e-12))


def _gaussian_slope(s, t):
    return -18.0 * CUT ** (s * s) * (t / (t + 1e-12))


def _gaussian_constants():
    """1 over the integral of `_gaussian` over the unit disc and ball."""
    shell = math.sqrt(math.pi) * math.erf(3.0) / 108.0 - CUT / 18.0  # of s² exp(-9 s²) from 0 to 1
    return {2: 1.0 / (math.pi * ((1.0 - CUT) / 9.0 - CUT)), 3: 1.0 / (4.0 * math.pi * (shell - CUT / 3.0))}


@dataclass(frozen=True)
class Smoothing:
    """One kernel: constants N by dimension, w(s, t) and slope(s, t), which NumPy and Taichi can both evaluate; reach:
    of its support, H / h."""

    constants: dict
    w: Any
    slope: Any
    reach: float = 2.0

    def weight(self, r, radius, dim):
        """W at distances r, of support `radius`, in any unit of length. NumPy."""
        s = r / radius
        t = 0.5 * (1.0 - s + abs(1.0 - s))
        return self.constants[dim] / radius**dim * self.w(s, t)

    def slope_over_r(self, r, radius, dim):
        """(1/r) dW/dr at distances r > 0. NumPy."""
        s = r / radius
        t = 0.5 * (1.0 - s + abs(1.0 - s))
        return self.constants[dim] / radius ** (dim + 2) * self.slope(s, t)

    def lattice_moment(self, radius, dim):
        """Second moment - sum (W'/r) x^2 of the kernel's slope over the unit lattice; 1 for a wide kernel.

        radius: support in lattice spacings; x: first coordinate of a lattice point.
        """
        axis = np.arange(-math.ceil(radius), math.ceil(radius) + 1.0)
        points = np.stack(np.meshgrid(*[axis] * dim, indexing="ij"), axis=-1).reshape(-1, dim)
        return float(-(self.slope_over_r(np.linalg.norm(points, axis=1), radius, dim) * points[:, 0] ** 2).sum())

    def lattice_share(self, radius, dim, power):
        """Mean of (W(r) / W(1))^power over the unit lattice, weighted by each point's part of `lattice_moment`.

        radius: support in lattice spacings.
        """
        axis = np.arange(-math.ceil(radius), math.ceil(radius) + 1.0)
        points = np.stack(np.meshgrid(*[axis] * dim, indexing="ij"), axis=-1).reshape(-1, dim)
        points = points[(points**2).sum(axis=1) > 0.0]
        r = np.linalg.norm(points, axis=1)
        part = -self.slope_over_r(r, radius, dim) * points[:, 0] ** 2
        return float((part * (self.weight(r, radius, dim) / self.weight(1.0, radius, dim)) ** power).sum() / part.sum())

    def functions(self, radius, dim):
        """Taichi functions weight(r), slope_over_r(r) for this support [cells]; zero beyond it.

        The slope is divided by its second moment on the unit lattice, which is 1 up to a per cent: a force that is not
        corrected otherwise makes a body that much too soft or too stiff.
        """
        w, slope = ti.func(self.w), ti.func(self.slope)
        inverse, of_w = 1.0 / radius, self.constants[dim] / radius**dim
        of_slope = of_w / radius**2 / self.lattice_moment(radius, dim)

        @ti.func
        def weight(r):
            s = r * inverse
            return of_w * w(s, ti.select(s < 1.0, 1.0 - s, 0.0))

        @ti.func
        def slope_over_r(r):
            s = r * inverse
            return of_slope * slope(s, ti.select(s < 1.0, 1.0 - s, 0.0))

        return weight, slope_over_r


KERNELS = {
    "wendland_c2": Smoothing({2: 7.0 / math.pi, 3: 21.0 / (2.0 * math.pi)}, _c2, _c2_slope),
    "wendland_c4": Smoothing({2: 9.0 / math.pi, 3: 495.0 / (32.0 * math.pi)}, _c4, _c4_slope),
    "wendland_c6": Smoothing({2: 78.0 / (7.0 * math.pi), 3: 1365.0 / (64.0 * math.pi)}, _c6, _c6_slope),
    "cubic_spline": Smoothing({2: 40.0 / (7.0 * math.pi), 3: 8.0 / math.pi}, _cubic, _cubic_slope),
    "gaussian": Smoothing(_gaussian_constants(), _gaussian, _gaussian_slope, 3.0),
}
