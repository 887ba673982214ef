"""What nodes beside an obstacle give it along one direction."""

import functools
from typing import NamedTuple

from snowmpm.compiler import ti
from snowmpm.compiler.groups import Array, grouped_kernel
from snowmpm.mpm.kernel_api import MASS, block_nodes
from snowmpm.particles.blocks import EDGE


class Nodes(NamedTuple):
    """Nodes of the contact blocks from offset on, coordinates of the blocks, and n_rows blocks to look at."""

    nodes: Array
    offset: int
    coordinates: Array
    rows: Array
    n_rows: int


class Around(NamedTuple):
    """A box of nodes around an obstacle: its first node, its nodes along each axis, and the number of each, -1 of those
    that are left out."""

    lower: Array
    shape: Array
    index: Array


@functools.cache
def push_kernels(dim, real, serial):
    """`note` keeps v . d of nodes; `add` adds m (v - v') . d to what they gave. A node lies in one contact block."""
    edge, n_nodes = EDGE[dim], block_nodes(dim)

    @ti.func
    def number(c, q, coordinates: ti.template(), around: ti.template()):
        at, inside, found = 0, 1, -1
        for a in ti.static(range(dim)):
            i = edge * coordinates[c, a] + q // ti.static(edge ** (dim - 1 - a)) % edge - around.lower[a]
            if i < 0 or i >= around.shape[a]:
                inside = 0
            at = at * around.shape[a] + i
        if inside == 1:
            found = around.index[at]
        return found

    @ti.func
    def along(node, direction: ti.template()):
        v = ti.cast(0.0, ti.f64)
        for a in ti.static(range(dim)):
            v += ti.cast(node[a], ti.f64) * direction[a]
        return v

    @grouped_kernel(real)
    def note(at: Nodes, around: Around, direction: Array, before: Array):
        ti.loop_config(serialize=ti.static(serial))
        for i in range(at.n_rows * n_nodes):
            c, q = at.rows[i // n_nodes], i % n_nodes
            m = number(c, q, at.coordinates, around)
            if m >= 0:
                before[m] = along(at.nodes[at.offset + c * n_nodes + q], direction)

    @grouped_kernel(real)
    def add(at: Nodes, around: Around, direction: Array, before: Array, given: Array):
        ti.loop_config(serialize=ti.static(serial))
        for i in range(at.n_rows * n_nodes):
            c, q = at.rows[i // n_nodes], i % n_nodes
            m = number(c, q, at.coordinates, around)
            if m >= 0:
                node = at.nodes[at.offset + c * n_nodes + q]
                given[m] += ti.cast(node[ti.static(MASS)], ti.f64) * (before[m] - along(node, direction))

    return note, add
