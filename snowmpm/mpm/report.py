"""What a step on the grid reports of a particle beside what every method does: where it is.

Every method's part: `snowmpm.stepping.step_report`.
"""

import functools
from types import SimpleNamespace

from snowmpm.compiler import ti
from snowmpm.mpm.grid import TILE
from snowmpm.mpm.transfer.stencil import STENCILS
from snowmpm.particles.blocks import EDGE
from snowmpm.stepping.step_report import BAD, larger, particle_report

FARTHEST_STEP = 1.5
"""Cells beyond the stencil's drift limit that a sort can still bring back; farther means an unstable step."""


@functools.cache
def report_functions(dim, real, basis):
    """Taichi functions that judge one particle and gather what is found of many."""
    edge, tile_edge, stencil = EDGE[dim], TILE[dim], STENCILS[basis]
    farthest = 0.5 * edge + stencil.drift_limit + FARTHEST_STEP
    of_particle = particle_report(real)

    @ti.func
    def judge(x, velocity, grad_v, growth, h, tau, work, iterations):
        """Report of one particle in a straight line, but for STRAIN, STRAINED, WAVE2 and BREAKING, which
        depend on the law."""
        report = of_particle.judge(velocity, grad_v, growth, h, tau, work, iterations)
        distance = ti.cast(0.0, real)
        for a in ti.static(range(dim)):
            distance = larger(ti.abs(x[a] - 0.5 * (edge + 1)), distance)
        report[BAD] = ti.select(distance <= farthest, report[BAD], 1.0)
        return report

    @ti.func
    def excursion(lowest, highest):
        """Largest distance from the owner block [cells] of positions between these."""
        return ti.max(0.0, (0.5 - lowest).max(), (highest - (edge + 0.5)).max())

    @ti.func
    def store_active_nodes(active_nodes: ti.template(), b, lowest, highest):
        """The nodes of the tile that stencils of positions between these touch; in which node blocks these lie, seen
        from which the tile is a step back, none or one ahead, as bits an axis (`BlockMap.node_blocks`)."""
        reached = 0
        for a in ti.static(range(dim)):
            first = ti.floor(lowest[a] - stencil.reach, ti.i32) + 1
            last = ti.floor(highest[a] - stencil.reach, ti.i32) + 1 + stencil.width
            active_nodes[b, 3 - dim + a] = ti.max(0, first)
            active_nodes[b, 6 - dim + a] = ti.min(tile_edge, last)
            sides = ti.select(last > edge + 1, 1, 0) + ti.select(first < 1, 4, 0)
            sides += ti.select((first <= edge) & (last > 1), 2, 0)
            reached |= sides << ti.static(3 * a)
        active_nodes[b, 6] = reached

    return SimpleNamespace(judge=judge, excursion=excursion, store_active_nodes=store_active_nodes,
                           strained=of_particle.strained, add_row=of_particle.add_row)
