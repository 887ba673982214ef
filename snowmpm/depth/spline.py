"""Quadratic B-spline of the plan grid: weights of the three nodes around a place, and their derivatives.

    N(u) = 3/4 - u^2 for |u| <= 1/2,  (3/2 - |u|)^2 / 2 for |u| <= 3/2,  0 beyond

f in [-1/2, 1/2): offset of the place from its nearest node, in cells; node k of 0, 1, 2 lies at k - 1. Derivatives are
by the place, per cell.
"""

from snowmpm.compiler import ti


@ti.func
def weights(f):
    """N at the three nodes (3,)."""
    return ti.Vector([0.5 * (0.5 - f) ** 2, 0.75 - f * f, 0.5 * (0.5 + f) ** 2])


@ti.func
def first_derivatives(f):
    """dN/df at the three nodes (3,)."""
    return ti.Vector([f - 0.5, -2.0 * f, f + 0.5])


@ti.func
def second_derivatives(f):
    """d2N/df2 at the three nodes (3,)."""
    one = 0.0 * f + 1.0  # of the type of f
    return ti.Vector([one, -2.0 * one, one])
