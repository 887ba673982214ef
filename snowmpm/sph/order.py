"""The order of the particles of a block: along a Morton curve through its cells, so that packs hold near neighbours."""

import functools

from snowmpm.compiler import ti
from snowmpm.compiler.launch import taichi_kernel
from snowmpm.compiler.parallel import chunk, chunks, is_worker, runs_serially
from snowmpm.particles.blocks import EDGE
from snowmpm.particles.store import accessors


@functools.cache
def order_kernel(layout):
    """Kernel that gives every particle the row that it has in the order of the Morton curve of its block."""
    dim, edge = layout.dim, EDGE[layout.dim]
    access, bits, serial = accessors(layout), {2: 3, 3: 2}[layout.dim], runs_serially()
    n_cells = edge**dim

    @ti.func
    def place_on_curve(x):
        """Number along the curve of the cell that a local position lies in."""
        code = 0
        for a in ti.static(range(dim)):
            cell = ti.max(0, ti.min(edge - 1, ti.floor(x[a] - 0.5, ti.i32)))
            for b in ti.static(range(bits)):
                code |= (cell >> b & 1) << (b * dim + dim - 1 - a)
        return code

    @taichi_kernel
    def order(reals: ti.types.ndarray(), slot_offset: int, start: ti.types.ndarray(), target: ti.types.ndarray(),
              chunk_bounds: ti.types.ndarray()):
        ti.loop_config(serialize=serial)
        for i in range(chunks(chunk_bounds)):
            if is_worker(i):
                begin, end = chunk(i, chunk_bounds)
                places = access.places(reals, slot_offset)
                row_of = ti.Vector.zero(ti.i32, n_cells + 1)
                for b in range(begin, end):
                    for c in range(n_cells + 1):
                        row_of[c] = 0
                    for p in range(start[b], start[b + 1]):
                        row_of[place_on_curve(access.load(reals, places, p, 0, dim)) + 1] += 1
                    for c in range(n_cells):
                        row_of[c + 1] += row_of[c]
                    for p in range(start[b], start[b + 1]):
                        c = place_on_curve(access.load(reals, places, p, 0, dim))
                        target[p] = start[b] + row_of[c]
                        row_of[c] += 1

    return order
