"""Stencils on a unit grid: what every transfer knows of its basis.

Positions are in cells: node i of the grid lies at x = i. A particle at x touches the nodes base, base + 1, ... along
each axis. With f = x - base (Steffen, Kirby & Berzins 2008, doi:10.1002/nme.2360):

    quadratic, 3 nodes, base = floor(x - 1/2), f in [1/2, 3/2):
        w = (3/2 - f)^2 / 2,   3/4 - (f - 1)^2,   (f - 1/2)^2 / 2
    cubic, 4 nodes, base = floor(x) - 1, f in [1, 2), t = f - 1, u = 2 - f:
        w = u^3 / 6,   2/3 - t^2 + t^3 / 2,   2/3 - u^2 + u^3 / 2,   t^3 / 6

They sum to 1 and reproduce x; their second moment is D = 1/4 and 1/3, for every x. So do the sums of the hat averaged
over a box of b cells (`schemes.Basis`), whose second moment changes with x. With 3 nodes and f as of the quadratic one:

    w_0 = [<t>^2 - <t - b>^2] / 2b,  t = 1 + b/2 - f,      w_2 the same of t = f - 1 + b/2,      w_1 = 1 - w_0 - w_2

<t>: t where it is positive, else 0. b = 1 gives the quadratic spline.
"""

from dataclasses import dataclass
from typing import Any

from snowmpm.compiler import ti
from snowmpm.schemes import BASES


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


def averaged_hat(box):
    """-> Taichi functions (weights, slopes) of the hat averaged over a box of `box` cells."""
    half = 0.5 * box

    @ti.func
    def weights(f):
        first, last = ti.max(1.0 + half - f, 0.0), ti.max(f - 1.0 + half, 0.0)
        first = (first**2 - ti.max(first - box, 0.0) ** 2) * ti.static(0.5 / box)
        last = (last**2 - ti.max(last - box, 0.0) ** 2) * ti.static(0.5 / box)
        return ti.Matrix.rows([first, 1.0 - first - last, last])

    @ti.func
    def slopes(f):
        first, last = ti.max(1.0 + half - f, 0.0), ti.max(f - 1.0 + half, 0.0)
        first = (ti.max(first - box, 0.0) - first) * ti.static(1.0 / box)
        last = (last - ti.max(last - box, 0.0)) * ti.static(1.0 / box)
        return ti.Matrix.rows([first, -first - last, last])

    return weights, slopes


@dataclass(frozen=True)
class Stencil:
    """One basis.

    width: nodes touched per axis; inverse_second_moment: D^-1 of the affine transfer [1/cells^2] (Jiang et al. 2015,
    doi:10.1145/2766996), None where it is not the same everywhere; drift_limit: how far [cells] a particle may be from
    its block before the stencil leaves the tile (see `mpm.grid`), a little less so that round-off does not count;
    weights(f), slopes(f): Taichi functions that give w and dw/dx [1/cell] as matrices [node, axis].
    """

    width: int
    inverse_second_moment: Any
    drift_limit: float
    weights: Any
    slopes: Any

    @property
    def reach(self):
        """base = floor(x - reach)."""
        return 0.5 * self.width - 1.0


STENCILS = {
    "quadratic": Stencil(3, 4.0, 0.999, _quadratic_weights, _quadratic_slopes),
    "cubic": Stencil(4, 3.0, 0.499, _cubic_weights, _cubic_slopes),
    **{name: Stencil(basis.width, None, 0.999, *averaged_hat(basis.box)) for name, basis in BASES.items() if basis.box},
}
