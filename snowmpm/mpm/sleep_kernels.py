"""What happens to particles and nodes when blocks of snow fall asleep (`mpm.sleep`)."""

import functools
from types import SimpleNamespace

from snowmpm.compiler import ti
from snowmpm.compiler.launch import taichi_kernel
from snowmpm.mpm.node import node_vector
from snowmpm.mpm.report import report_functions
from snowmpm.particles.blocks import EDGE
from snowmpm.particles.material_table import DENSITY
from snowmpm.particles.store import accessors


@functools.cache
def sleep_kernels(layout, real, basis, flip):
    """`lull(...)` stops the particles of some blocks, `clear(...)` empties contact blocks that nobody reaches."""
    dim, edge = layout.dim, EDGE[layout.dim]
    access, at = accessors(layout), layout.offsets
    judged = report_functions(dim, real, basis)
    of_node = node_vector(real, flip)

    @taichi_kernel
    def lull(reals: ti.types.ndarray(), slot_offset: int, material: ti.types.ndarray(), materials: ti.types.ndarray(),
             start: ti.types.ndarray(), chosen: ti.types.ndarray(), active_nodes: ti.types.ndarray(),
             sums: ti.types.ndarray()):
        """Stop the particles of the blocks `chosen`, and find the nodes that they reach. A row of `sums` for each:
        mass, m v^2 and m C:C before, momentum before."""
        for i in range(sums.shape[0]):
            places, b = access.places(reals, slot_offset), chosen[i]
            total = ti.Vector.zero(ti.f64, 3 + dim)
            lowest, highest = ti.Vector([2.0 * edge] * dim, real), ti.Vector([-1.0 * edge] * dim, real)
            for p in range(start[b], start[b + 1]):
                x = access.load(reals, places, p, at["position"], dim)
                lowest, highest = ti.min(lowest, x), ti.max(highest, x)
                v = ti.cast(access.load(reals, places, p, at["velocity"], dim), ti.f64)
                C = ti.cast(access.load(reals, places, p, at["affine"], dim * dim), ti.f64)
                volume = ti.cast(access.load(reals, places, p, at["volume"], 1)[0], ti.f64)
                mass = volume * materials[material[p], DENSITY]
                total[0] += mass
                total[1] += mass * v.norm_sqr()
                total[2] += mass * C.norm_sqr()
                for a in ti.static(range(dim)):
                    total[3 + a] += mass * v[a]
                access.store(reals, places, p, at["velocity"], ti.Vector.zero(real, dim + dim * dim))
            for c in ti.static(range(3 + dim)):
                sums[i, c] = total[c]
            judged.store_active_nodes(active_nodes, b, lowest, highest)

    @taichi_kernel
    def clear(nodes: ti.types.ndarray(dtype=of_node, ndim=1), offset: int, stride: int, chosen: ti.types.ndarray()):
        """Empty the contact blocks `chosen`, `stride` nodes each from `offset` on."""
        for i in range(chosen.shape[0]):
            for q in range(stride):
                nodes[offset + chosen[i] * stride + q] = of_node(0.0)

    return SimpleNamespace(lull=lull, clear=clear)
