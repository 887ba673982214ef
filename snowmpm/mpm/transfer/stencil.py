"""B-spline stencils on a unit grid: what every transfer knows of its basis.

Positions are in cells: node i of the grid lies at x = i. A particle at x touches the nodes base, base + 1, ... along
each axis. With f = x - base (Steffen, Kirby & Berzins 2008, doi:10.1002/nme.2360):

    quadratic, 3 nodes, base = floor(x - 1/2), f in [1/2, 3/2):
        w = (3/2 - f)^2 / 2,   3/4 - (f - 1)^2,   (f - 1/2)^2 / 2
    cubic, 4 nodes, base = floor(x) - 1, f in [1, 2), t = f - 1, u = 2 - f:
        w = u^3 / 6,   2/3 - t^2 + t^3 / 2,   2/3 - u^2 + u^3 / 2,   t^3 / 6

They sum to 1 and reproduce x; their second moment is D = 1/4 and 1/3, for every x.
"""

from dataclasses import dataclass

import taichi as ti


@ti.func
def _quadratic_weights(f):
    return ti.Matrix.rows([0.5 * (1.5 - f) ** 2, 0.75 - (f - 1.0) ** 2, 0.5 * (f - 0.5) ** 2])


@ti.func
def _quadratic_slopes(f):
    return ti.Matrix.rows([f - 1.5, 2.0 - 2.0 * f, f - 0.5])


@ti.func
def _cubic_weights(f):
    t, u = f - 1.0, 2.0 - f
    t2, u2 = t * t, u * u
    third, sixth = ti.static(2.0 / 3.0), ti.static(1.0 / 6.0)
    return ti.Matrix.rows([sixth * u2 * u, third - t2 * (1.0 - 0.5 * t), third - u2 * (1.0 - 0.5 * u), sixth * t2 * t])


@ti.func
def _cubic_slopes(f):
    t, u = f - 1.0, 2.0 - f
    return ti.Matrix.rows([-0.5 * u * u, t * (1.5 * t - 2.0), u * (2.0 - 1.5 * u), 0.5 * t * t])


@dataclass(frozen=True)
class Stencil:
    """One basis.

    width: nodes touched per axis; inverse_second_moment: D^-1 of the affine transfer [1/cells^2] (Jiang et al. 2015,
    doi:10.1145/2766996); drift_limit: how far [cells] a particle may be from its block before the stencil leaves the
    tile (see `mpm.grid`), a little less so that round-off does not count; weights(f), slopes(f): Taichi functions that
    give w and dw/dx [1/cell] as matrices [node, axis].
    """

    width: int
    inverse_second_moment: float
    drift_limit: float
    weights: object
    slopes: object

    @property
    def reach(self):
        """base = floor(x - reach)."""
        return 0.5 * self.width - 1.0


STENCILS = {
    "quadratic": Stencil(3, 4.0, 0.999, _quadratic_weights, _quadratic_slopes),
    "cubic": Stencil(4, 3.0, 0.499, _cubic_weights, _cubic_slopes),
}
