"""Obstacles inside a kernel: their shapes and poses as tables, their distance as a Taichi function.

Lengths are cells of `dx` from `origin`, as in a solver. A kernel takes the four tables of a `SolidTable` and calls, for
obstacle number o and the position x [cells] of a node, with `distance = distance_function(dim, real)`,

    d, n = distance(o, x, numbers, sizes, poses, samples)   # signed distance [cells], outward normal, in space
"""

import functools

import numpy as np

from snowmpm.compiler import runtime, ti
from snowmpm.solids.primitives import SAMPLED, primitive_distance
from snowmpm.solids.samples import sampled_distance

SPACING = 0.5
"""Spacing of the samples of a polygon or mesh [cells]."""

REACH = 4.0
"""Cells around the surface of a polygon or mesh in which its distance is sampled."""

# Columns of `numbers` and of `sizes`
KIND, CODE, FIRST, SHAPE = 0, 1, 2, 3
SIZE, LOWER, STEP, CUT_OFF, FRICTION = 0, 3, 6, 7, 8


def pose_columns(dim):
    """First column of `poses` of each entry: axes (dim x dim, by rows), middle, box; and their number."""
    ends = np.cumsum([0, dim * dim, dim, dim, dim])
    return dict(zip(("axes", "middle", "lower", "upper", "end"), ends.tolist(), strict=True))


class SolidTable:
    """Tables of obstacles for kernels of one precision.

    numbers (n, 6) int32: kind, contact code, first sample, shape of the samples; sizes (n, 9) float64 [cells]: size,
    first corner, spacing and reach of the samples, friction [-]; poses (n, ...) float64: columns of `pose_columns`, for
    the time of the last `move`, a NumPy array, which kernels take as it is; samples: vectors of 4, normal and distance
    [cells].
    """

    def __init__(self, obstacles, *, dim, precision, origin, dx):
        self.obstacles, self.dim, self.dx = list(obstacles), dim, dx
        self.origin = np.asarray(origin, float)
        self.count = len(self.obstacles)
        runtime.start()
        rows = max(1, self.count)
        numbers, sizes = np.zeros((rows, SHAPE + 3), np.int32), np.zeros((rows, FRICTION + 1))
        parts, first = [], 0
        for o, obstacle in enumerate(self.obstacles):
            shape = obstacle.shape
            numbers[o, :SHAPE] = shape.kind, obstacle.code, first
            sizes[o, :dim], sizes[o, FRICTION] = shape.size / dx, obstacle.friction
            if shape.kind == SAMPLED:
                found = shape.samples(SPACING * dx, REACH * dx, f"obstacle {obstacle.name}")
                numbers[o, SHAPE : SHAPE + dim] = found.shape
                sizes[o, LOWER : LOWER + dim] = found.lower / dx
                sizes[o, STEP], sizes[o, CUT_OFF] = found.spacing / dx, found.reach / dx
                parts.append(found.values / ([1.0] * 3 + [dx]))
                first += len(found.values)
        real, numpy_real = runtime.DTYPES[precision]
        self.numbers, self.sizes = _on_device(numbers, ti.i32), _on_device(sizes, ti.f64)
        self.samples = ti.ndarray(ti.types.vector(4, real), (max(1, first),))
        if parts:
            self.samples.from_numpy(np.concatenate(parts).astype(numpy_real))
        self._columns = pose_columns(dim)
        self.poses = np.zeros((rows, self._columns["end"]))
        self._moved = False

    def move(self, time):
        """Put every obstacle where it is at `time` [s]. Costs nothing when none moves."""
        if self._moved and all(obstacle.still for obstacle in self.obstacles):
            return
        self._moved = True
        at, dx = self._columns, self.dx
        for row, obstacle in zip(self.poses, self.obstacles, strict=False):
            pose = obstacle.motion.pose(time)
            middle, axes = obstacle.frame(pose)
            half = obstacle.half_sides(axes)
            row[: at["middle"]] = axes.ravel()
            row[at["middle"] : at["lower"]] = (middle - self.origin) / dx
            row[at["lower"] : at["upper"]] = (middle - half - self.origin) / dx
            row[at["upper"] :] = (middle + half - self.origin) / dx

    def boxes(self):
        """Lower and upper corners (n, dim) [cells] of boxes that hold the obstacles where they are now."""
        first, middle, last = (self._columns[name] for name in ("lower", "upper", "end"))
        return self.poses[: self.count, first:middle], self.poses[: self.count, middle:last]


def _on_device(values, dtype):
    array = ti.ndarray(dtype, values.shape)
    array.from_numpy(values)
    return array


@functools.cache
def distance_function(dim, real):
    """The Taichi function `distance` of a precision (see the top)."""
    at = pose_columns(dim)
    axes, middle = at["axes"], at["middle"]

    @ti.func
    def entry(n: ti.template(), column: ti.template(), o, table: ti.template()):
        return ti.Vector([table[o, column + k] for k in ti.static(range(n))])

    @ti.func
    def distance(o, x, numbers: ti.template(), sizes: ti.template(), poses: ti.template(), samples: ti.template()):
        # In double: x and the middle of the solid may be far from the origin, and close to each other.
        away = x - entry(dim, middle, o, poses)
        local, out = ti.Vector.zero(real, dim), ti.Vector.zero(real, dim)
        for k in ti.static(range(dim)):
            local[k] = ti.cast(entry(dim, ti.static(axes + k * dim), o, poses).dot(away), real)
        d, n = ti.cast(0.0, real), ti.Vector.zero(real, dim)
        if numbers[o, KIND] == SAMPLED:
            lower = ti.cast(entry(dim, LOWER, o, sizes), real)
            step, reach = ti.cast(sizes[o, STEP], real), ti.cast(sizes[o, CUT_OFF], real)
            shape = entry(dim, SHAPE, o, numbers)
            d, n = sampled_distance(dim, local, lower, step, shape, numbers[o, FIRST], reach, samples)
        else:
            d, n = primitive_distance(dim, numbers[o, KIND], local, ti.cast(entry(3, SIZE, o, sizes), real))
        for k in ti.static(range(dim)):
            out += n[k] * ti.cast(entry(dim, ti.static(axes + k * dim), o, poses), real)
        return d, out

    return distance
