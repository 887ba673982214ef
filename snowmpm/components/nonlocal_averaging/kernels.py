"""Kernels of the average of a loss of strength (`.average`)."""

import functools
from types import SimpleNamespace
from typing import NamedTuple

from snowmpm.compiler import ti
from snowmpm.compiler.groups import Array, Real, grouped_kernel
from snowmpm.compiler.launch import taichi_kernel
from snowmpm.compiler.parallel import chunk, chunks, is_worker
from snowmpm.particles.blocks import EDGE
from snowmpm.particles.store import accessors


class Rows(NamedTuple):
    """Particles by blocks."""

    reals: Array
    slot_offset: int
    material: Array
    start: Array
    coordinates: Array
    chunk_bounds: Array


class Nodes(NamedTuple):
    """A lattice: sums of (V Δκ, V) of its nodes; first node, number of nodes, whether they repeat (dim each); nodes per
    cell (dim); material -> whether it is averaged here."""

    sums: Array
    first: Array
    count: Array
    repeats: Array
    per_cell: Array
    averaged: Array


@functools.cache
def averaging_kernels(layout, real, index, serial):
    """Kernels `remember`, `gain`, `clear`, `scatter`, `blur` and `gather` of state variable `index`; serial: by one
    thread."""
    dim, edge = layout.dim, EDGE[layout.dim]
    access, at = accessors(layout), layout.offsets
    column = at["state"] + index

    @ti.func
    def add(sums: ti.template(), k, value):
        if ti.static(serial):
            sums[k] = sums[k] + value
        else:
            ti.atomic_add(sums[k], value)

    @ti.func
    def locate(nodes: ti.template(), x, b, coordinates: ti.template()):
        """Numbers of the first of three nodes along each axis, and their weights by axis."""
        base, w = ti.Vector.zero(ti.i32, dim), ti.Matrix.zero(ti.f64, dim, 3)
        for a in ti.static(range(dim)):
            y = (ti.cast(edge * coordinates[b, a], ti.f64) + ti.cast(x[a], ti.f64)) * nodes.per_cell[a]
            base[a] = ti.floor(y - 0.5, ti.i32)
            f = y - ti.cast(base[a], ti.f64)
            w[a, 0], w[a, 1], w[a, 2] = 0.5 * (1.5 - f) ** 2, 0.75 - (f - 1.0) ** 2, 0.5 * (f - 0.5) ** 2
            base[a] -= nodes.first[a]
        return base, w

    @ti.func
    def node(nodes: ti.template(), base, step: ti.template()):
        """Number of a node, `step` from the first of its particle."""
        k = 0
        for a in ti.static(range(dim)):
            n = nodes.count[a]
            i = base[a] + step[a]
            if nodes.repeats[a] == 1:
                i = (i % n + n) % n
            k = k * n + ti.max(0, ti.min(n - 1, i))
        return k

    @grouped_kernel(real)
    def remember(rows: Rows, kept: Array, count: int):
        ti.loop_config(serialize=ti.static(serial))
        for p in range(count):
            kept[p] = access.load(rows.reals, access.places(rows.reals, rows.slot_offset), p, column, 1)[0]

    @grouped_kernel(real)
    def gain(rows: Rows, kept: Array, averaged: Array, most: Array, count: int):
        """Replace the κ that `kept` has from before the step by the gain Δκ, of materials that are averaged; `most`:
        the largest gain in size."""
        ti.loop_config(serialize=ti.static(serial))
        for p in range(count):
            places = access.places(rows.reals, rows.slot_offset)
            more = access.load(rows.reals, places, p, column, 1)[0] - kept[p]
            if averaged[ti.cast(rows.material[p], ti.i32)] == 1:
                kept[p] = more
                if more != 0.0:
                    ti.atomic_max(most[0], ti.abs(ti.cast(more, ti.f64)))

    @taichi_kernel
    def clear(sums: ti.types.ndarray(), n: int):
        ti.loop_config(serialize=ti.static(serial))
        for k in range(n):
            sums[k] = ti.cast(0, ti.i64)

    @grouped_kernel(real)
    def scatter(rows: Rows, nodes: Nodes, kept: Array, per_gain: Real, per_volume: Real):
        ti.loop_config(serialize=ti.static(serial))
        for i in range(chunks(rows.chunk_bounds)):
            if is_worker(i):
                begin, end = chunk(i, rows.chunk_bounds)
                places = access.places(rows.reals, rows.slot_offset)
                for b in range(begin, end):
                    for p in range(rows.start[b], rows.start[b + 1]):
                        if nodes.averaged[ti.cast(rows.material[p], ti.i32)] == 1:
                            x = access.load(rows.reals, places, p, at["position"], dim)
                            base, w = locate(nodes, x, b, rows.coordinates)
                            volume = access.load(rows.reals, places, p, at["volume"], 1)[0]
                            volume *= access.load(rows.reals, places, p, at["volume_ratio"], 1)[0]
                            share = ti.cast(volume, ti.f64) * per_volume
                            more = ti.cast(kept[p], ti.f64) * per_gain
                            for step in ti.static(ti.ndrange(*(3,) * dim)):
                                k, weight = node(nodes, base, step), share
                                for a in ti.static(range(dim)):
                                    weight *= w[a, step[a]]
                                add(nodes.sums, 2 * k + 1, ti.cast(weight, ti.i64))
                                if more != 0.0:
                                    add(nodes.sums, 2 * k, ti.cast(weight * more, ti.i64))

    @taichi_kernel
    def blur(sums: ti.types.ndarray(), out: ti.types.ndarray(), n_nodes: int, stride: int, count: int, repeats: int):
        """[1 4 6 4 1] along an axis of `count` nodes that are `stride` apart."""
        ti.loop_config(serialize=ti.static(serial))
        for k in range(n_nodes):
            i = k // stride % count
            for c in ti.static(range(2)):
                total = ti.cast(0, ti.i64)
                for step, weight in ti.static(((-2, 1), (-1, 4), (0, 6), (1, 4), (2, 1))):
                    j = i + step
                    if repeats == 1:
                        j = (j % count + count) % count
                    if 0 <= j < count:
                        total += weight * sums[2 * (k + (j - i) * stride) + c]
                out[2 * k + c] = total

    @grouped_kernel(real)
    def gather(rows: Rows, nodes: Nodes, kept: Array, per_gain: Real):
        ti.loop_config(serialize=ti.static(serial))
        for i in range(chunks(rows.chunk_bounds)):
            if is_worker(i):
                begin, end = chunk(i, rows.chunk_bounds)
                places = access.places(rows.reals, rows.slot_offset)
                for b in range(begin, end):
                    for p in range(rows.start[b], rows.start[b + 1]):
                        if nodes.averaged[ti.cast(rows.material[p], ti.i32)] == 1:
                            x = access.load(rows.reals, places, p, at["position"], dim)
                            base, w = locate(nodes, x, b, rows.coordinates)
                            above, below = ti.cast(0.0, ti.f64), ti.cast(0.0, ti.f64)
                            for step in ti.static(ti.ndrange(*(3,) * dim)):
                                k, weight = node(nodes, base, step), ti.cast(1.0, ti.f64)
                                for a in ti.static(range(dim)):
                                    weight *= w[a, step[a]]
                                above += weight * ti.cast(nodes.sums[2 * k], ti.f64)
                                below += weight * ti.cast(nodes.sums[2 * k + 1], ti.f64)
                            mean = ti.cast(above / (per_gain * ti.max(below, 1.0)), real)
                            now = access.load(rows.reals, places, p, column, 1)
                            now[0] += mean - kept[p]
                            access.store(rows.reals, places, p, column, now)

    return SimpleNamespace(remember=remember, gain=gain, clear=clear, scatter=scatter, blur=blur, gather=gather)
