"""Signed distance of any solid from samples on a grid that is fixed to it.

    d(x) = sum_i w_i (d_i + n_i . (x - x_i) / 2),   n(x) = sum_i w_i n_i, normalised,

with the bilinear (2-D) or trilinear weights w_i of the cell's corners. d is exact for quadratic functions: where the
surface is smooth its error falls with the third power of the spacing, and planes are met exactly.
"""

from dataclasses import dataclass

import numpy as np

from snowmpm.compiler import ti
from snowmpm.errors import InputError

LARGEST = 16_000_000
"""Samples of one solid, 0.25 GB in float32."""

CUT = 0.9999
"""Share of the reach above which a sample counts as truncated."""


@dataclass(frozen=True, eq=False)
class DistanceSamples:
    """Samples of a signed distance.

    lower (dim,) [m]: the first one; spacing [m]; shape (dim,); values (n, 4) in row-major order: normal (dim numbers),
    distance [m] last; reach [m]: farther from the surface than this the distance is +-reach.
    """

    lower: np.ndarray
    spacing: float
    shape: tuple
    values: np.ndarray
    reach: float

    @classmethod
    def of(cls, query, lower, upper, spacing, reach, name):
        """Sample `query(points) -> distance, normal`, truncated at `reach`, in a box [m] and `reach` around it.

        If there are more than `LARGEST` samples, the spacing is doubled. InputError: still more.
        """
        lower, upper = lower - reach, upper + reach
        for coarser in (1.0, 2.0):
            shape = tuple(int(n) for n in np.ceil((upper - lower) / (coarser * spacing)) + 1)
            if np.prod(shape, dtype=float) <= LARGEST:
                break
        else:
            raise InputError(f"{name}: too large for this solver.dx: its distance takes {' x '.join(map(str, shape))}"
                             f" samples, and at most {LARGEST:.2g} fit; coarsen solver.dx or make it smaller")
        spacing *= coarser
        dim = len(shape)
        axes = [lower[k] + spacing * np.arange(shape[k]) for k in range(dim)]
        values = np.zeros((int(np.prod(shape)), 4))
        rest = np.stack(np.meshgrid(*axes[1:], indexing="ij"), axis=-1).reshape(-1, dim - 1)
        for i, x in enumerate(axes[0]):  # by planes: bounds the memory
            points = np.column_stack([np.full(len(rest), x), rest])
            rows = slice(i * len(rest), (i + 1) * len(rest))
            values[rows, 3], values[rows, :dim] = query(points)
        return cls(lower, spacing, shape, values, reach)


@ti.func
def sampled_distance(dim: ti.template(), x, lower, spacing, shape, first, reach, samples: ti.template()):
    """d, n at x from samples[first ...]; lower, spacing, reach and x in one unit; beyond the grid d = reach."""
    base = ti.Vector.zero(ti.i32, dim)
    share, near = x * 0.0, 1
    for k in ti.static(range(dim)):
        at = (x[k] - lower[k]) / spacing
        if not (at >= 0.0 and at <= shape[k] - 1.0):
            near = 0
        at = ti.min(ti.max(at, 0.0), shape[k] - 1.0)
        base[k] = ti.min(ti.cast(at, ti.i32), shape[k] - 2)
        share[k] = at - base[k]
    d, n = x[0] * 0.0, x * 0.0
    nearest = x * 0.0
    closest = d + 4.0
    for corner in ti.static(range(2**dim)):
        weight, number, arm2, along = d * 0.0 + 1.0, 0, d * 0.0, d * 0.0
        for k in ti.static(range(dim)):
            number = number * shape[k] + base[k] + ti.static(corner >> k & 1)
        sample = samples[first + number]
        for k in ti.static(range(dim)):
            offset = share[k] - ti.static(float(corner >> k & 1))
            weight *= 1.0 - ti.abs(offset)
            along += sample[k] * offset
            arm2 += offset**2
        # A truncated distance has no gradient.
        slope = ti.select(ti.abs(sample[3]) < CUT * reach, spacing, d * 0.0)
        if arm2 < closest:
            closest = arm2
            for k in ti.static(range(dim)):
                nearest[k] = sample[k]
        d_corner = sample[3] + 0.5 * slope * along
        for k in ti.static(range(dim)):
            n[k] += weight * sample[k]
        d += weight * d_corner
    length = n.norm()
    n = ti.select(length > 1e-3, n / ti.max(length, 1e-30), nearest)
    if near == 0:
        d = reach
    return d, n
