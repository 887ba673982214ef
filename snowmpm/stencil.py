"""Quadratic B-spline stencil on a unit grid, with symbols that every transfer shares.

Positions are in cells: node i of the grid lies at x = i. A particle at x touches the 3 nodes base, base + 1, base + 2
per axis, base = floor(x - 1/2), with weights (Steffen, Kirby & Berzins 2008, doi:10.1002/nme.2360)

    w0 = (3/2 - f)^2 / 2,   w1 = 3/4 - (f - 1)^2,   w2 = (f - 1/2)^2 / 2,   f = x - base in [1/2, 3/2).

They sum to 1 and reproduce x; their second moment is D = 1/4, for every x.
"""

import taichi as ti

WIDTH = 3
"""Nodes touched per axis."""

INVERSE_SECOND_MOMENT = 4.0
"""D^-1 of the affine transfer, in 1/cells^2 (Jiang et al. 2015, doi:10.1145/2766996)."""


@ti.func
def quadratic_stencil(x):
    """-> base node (integers), f = x - base, weights[node, axis]."""
    base = ti.floor(x - 0.5, ti.i32)
    f = x - ti.cast(base, float)
    w = ti.Matrix.rows([0.5 * (1.5 - f) ** 2, 0.75 - (f - 1.0) ** 2, 0.5 * (f - 0.5) ** 2])
    return base, f, w
