"""An obstacle on the grid: its distance and normal at the nodes of the node blocks near it, for where it is now."""

import functools

import numpy as np

from snowmpm.compiler import ti
from snowmpm.compiler.arrays import int_array
from snowmpm.compiler.launch import taichi_kernel
from snowmpm.compiler.runtime import DTYPES
from snowmpm.mpm.contact.walls import FREE, NEAR
from snowmpm.particles.blocks import EDGE
from snowmpm.solids.table import SolidTable, distance_function

MARGIN = 4.0
"""Cells around a solid's box in which node blocks are prepared for it."""


class SolidField:
    """Geometry of a `Surface` made of one obstacle (`solids.Obstacle`)."""

    stored = True

    def __init__(self, obstacle, *, dim, precision, origin, dx):
        self.obstacle, self.dim = obstacle, dim
        self._origin, self._dx = origin, dx
        self._table = SolidTable([obstacle], dim=dim, precision=precision, origin=origin, dx=dx)
        self._table.move(0.0)
        self._real = DTYPES[precision][0]
        self.bind(False)
        self._box = self._prepared = self._table.boxes()
        self._n = 0
        self.array = self._allocate(8)

    def bind(self, serial):
        """Compile for one thread or all of them."""
        self._fill = _fill_kernel(self.dim, self._real, serial)

    def _allocate(self, slots):
        return ti.ndarray(ti.types.vector(4, self._real), (slots * EDGE[self.dim] ** self.dim,))

    def slots(self, keys, coordinates):
        """Slot of each node block (coordinates (n, dim)), or FREE."""
        edge = EDGE[self.dim]
        lower, upper = (corner[0].copy() for corner in self._table.boxes())
        first = edge * coordinates
        near = ((first + edge - 1 >= lower - MARGIN) & (first <= upper + MARGIN)).all(axis=1)
        self._prepared = lower, upper
        self._n = int(near.sum())
        self._coordinates = int_array(coordinates[near])
        if self._n * edge**self.dim > self.array.shape[0]:
            self.array = self._allocate(2 * self._n)
        self._measure()
        slots = np.full(len(keys), FREE, np.int32)
        slots[near] = np.arange(self._n)
        return slots

    def move_to(self, time):
        """Take the place of `time` [s]; -> whether it has gone farther than the node blocks that are prepared."""
        self._table.move(time)
        self._measure()
        moved = max(np.abs(now[0] - then).max() for now, then in zip(self._table.boxes(), self._prepared, strict=True))
        return moved > MARGIN - NEAR

    def distance(self, points):
        """Signed distance [cells] at points (k, dim) [cells] of a solid at rest."""
        return self.obstacle.shape.query(points * self._dx + self._origin)[0] / self._dx

    def _measure(self):
        table = self._table
        if self._n:
            self._fill(self.array, self._coordinates, table.numbers, table.sizes, table.poses, table.samples, self._n)


@functools.cache
def _fill_kernel(dim, real, serial):
    vec4, edge, distance = ti.types.vector(4, real), EDGE[dim], distance_function(dim, real)
    n_nodes = edge**dim

    @taichi_kernel
    def fill(walls: ti.types.ndarray(dtype=vec4, ndim=1), coordinates: ti.types.ndarray(), numbers: ti.types.ndarray(),
             sizes: ti.types.ndarray(), poses: ti.types.ndarray(), samples: ti.types.ndarray(dtype=vec4, ndim=1),
             n_slots: int):
        ti.loop_config(serialize=ti.static(serial))
        for i in range(n_slots * n_nodes):
            x, node = ti.Vector.zero(ti.f64, dim), vec4(0.0)
            for a in ti.static(range(dim)):
                x[a] = edge * coordinates[i // n_nodes, a] + i // ti.static(edge ** (dim - 1 - a)) % edge
            d, n = distance(0, x, numbers, sizes, poses, samples)
            for a in ti.static(range(dim)):
                node[a] = n[a]
            node[3] = d
            walls[i] = node

    return fill
