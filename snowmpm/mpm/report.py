"""What a step reports: the extremes that set the next step, the sums of the audit, and what went wrong."""

import functools
from types import SimpleNamespace

import taichi as ti

from snowmpm.blocks import EDGE
from snowmpm.mpm.grid import TILE
from snowmpm.stencil import STENCILS
from snowmpm.timestep import DEFORMATION_LIMIT, FREE_LIMIT

SPEED2, GRADIENT2, STRAIN, EXCURSION, DISSIPATION, UNCONVERGED, BAD, PLASTIC, WAVE2 = range(9)
"""Columns of a block's report: largest |v|^2, |grad v|^2 (less without stress), |be - I| of laws of constant
stiffness and excursion from home [cells]; sums of plastic work [J] and of particles whose return map failed; index + 1
of a particle that is not finite or inverted; number of particles that yielded; largest squared wave speed of the laws
that stiffen."""

N_REPORT = 9

SUMMED = (DISSIPATION, UNCONVERGED, PLASTIC)

FREE_SHARE = (DEFORMATION_LIMIT / FREE_LIMIT) ** 2
"""What the squared velocity gradient of a grain without stress counts."""

FARTHEST_STEP = 1.5
"""Cells beyond the stencil's home limit that a sort can still bring back; farther means an unstable step."""


@ti.func
def larger(a, b):
    """Larger number or, entry by entry, vector; b where a is not a number. One instruction, unlike ti.max."""
    return ti.select(a > b, a, b)


@functools.cache
def report_functions(dim, real, basis):
    """Taichi functions that judge one particle and gather what is found of many."""
    edge, tile_edge, stencil = EDGE[dim], TILE[dim], STENCILS[basis]
    farthest = 0.5 * edge + stencil.home_limit + FARTHEST_STEP

    @ti.func
    def is_finite(x):
        """By the bits of the exponent: fast floating-point mode may optimise a comparison with NaN away."""
        finite = True
        if ti.static(real == ti.f32):
            finite = (ti.bit_cast(ti.cast(x, ti.f32), ti.i32) & 0x7F800000) != 0x7F800000
        else:
            finite = ((ti.bit_cast(ti.cast(x, ti.f64), ti.i64) >> 52) & 0x7FF) != 0x7FF
        return finite

    @ti.func
    def judge(x, velocity, grad_v, growth, h, tau, work, iterations):
        """Report of one particle in a straight line, but for STRAIN and WAVE2, which depend on the law."""
        report = ti.Vector.zero(real, N_REPORT)
        report[SPEED2] = velocity.norm_sqr()
        report[GRADIENT2] = grad_v.norm_sqr() * ti.select(tau.norm_sqr() > 0.0, 1.0, FREE_SHARE)
        report[DISSIPATION] = work
        report[UNCONVERGED] = ti.select(iterations < 0, 1.0, 0.0)
        report[PLASTIC] = ti.select(iterations != 0, 1.0, 0.0)
        distance = ti.cast(0.0, real)
        for a in ti.static(range(dim)):
            distance = larger(ti.abs(x[a] - 0.5 * (edge + 1)), distance)
        sound = is_finite(report[SPEED2] + report[GRADIENT2] + h.norm_sqr() + tau.sum())
        report[BAD] = ti.select(sound & (growth > 0.0) & (distance <= farthest), 0.0, 1.0)
        return report

    @ti.func
    def excursion(lowest, highest):
        """Largest distance from home [cells] of positions between these."""
        return ti.max(0.0, (0.5 - lowest).max(), (highest - (edge + 0.5)).max())

    @ti.func
    def store_box(boxes: ti.template(), b, lowest, highest):
        """The nodes of the tile that stencils of positions between these touch."""
        for a in ti.static(range(dim)):
            first = ti.floor(lowest[a] - stencil.reach, ti.i32) + 1
            last = ti.floor(highest[a] - stencil.reach, ti.i32) + 1 + stencil.width
            boxes[b, 3 - dim + a] = ti.max(0, first)
            boxes[b, 6 - dim + a] = ti.min(tile_edge, last)

    @ti.func
    def reduce_report(reports: ti.template(), report: ti.template(), n_tiles):
        for c in ti.static(range(N_REPORT)):
            report[c] = 0.0
        for b in range(n_tiles):
            for c in ti.static(range(N_REPORT)):
                if ti.static(c in SUMMED):
                    report[c] += reports[b, c]
                else:
                    report[c] = ti.max(report[c], reports[b, c])

    return SimpleNamespace(judge=judge, excursion=excursion, store_box=store_box, reduce_report=reduce_report)
