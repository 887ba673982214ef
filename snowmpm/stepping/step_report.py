"""What a step reports: the extremes that set the next step, the sums of the audit, and what went wrong."""

import functools
from types import SimpleNamespace

from snowmpm.compiler import ti
from snowmpm.compiler.parallel import in_order, partial_sums
from snowmpm.stepping.time_step import DEFORMATION_LIMIT, FREE_LIMIT, LARGE_STRAIN, SMALL_STRAIN

SPEED2, GRADIENT2, STRAIN, EXCURSION, DISSIPATION, UNCONVERGED, BAD, PLASTIC, WAVE2, BREAKING, STRAINED = range(11)
"""Columns of a block's report: largest |v|^2, |grad v|^2 (less without stress), |be - I| of laws of constant stiffness
and excursion (from the owner block [cells] on a grid; squared speed over that of all [m2/s2] in SPH); sums of plastic
work [J] and of particles whose return map failed; index + 1 of a particle that is not finite or inverted; number of
particles that yielded; largest squared wave speed of the laws that stiffen; number of particles that lost bonds and
have some left; what particles beyond SMALL_STRAIN count, in PARTS."""

N_REPORT = 11

SUMMED = (DISSIPATION, UNCONVERGED, PLASTIC, BREAKING, STRAINED)

PARTS = 256
"""What a particle of LARGE_STRAIN counts in STRAINED: whole numbers have the same sum in any order."""

FREE_SHARE = (DEFORMATION_LIMIT / FREE_LIMIT) ** 2
"""What the squared velocity gradient of a grain without stress counts."""


@ti.func
def larger(a, b):
    """Larger number or, entry by entry, vector; b where a is not a number. One instruction, unlike ti.max."""
    return ti.select(a > b, a, b)


@functools.cache
def particle_report(real):
    """Taichi functions that judge one particle of any method and gather what is found of many."""

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
    def judge(velocity, grad_v, growth, h, tau, work, iterations):
        """Report of one particle in a straight line, but for STRAIN, STRAINED, WAVE2, BREAKING and EXCURSION."""
        report = ti.Vector.zero(real, N_REPORT)
        report[SPEED2] = velocity.norm_sqr()
        report[GRADIENT2] = grad_v.norm_sqr() * ti.select(tau.norm_sqr() > 0.0, 1.0, FREE_SHARE)
        report[DISSIPATION] = work
        report[UNCONVERGED] = ti.select(iterations < 0, 1.0, 0.0)
        report[PLASTIC] = ti.select(iterations != 0, 1.0, 0.0)
        sound = is_finite(report[SPEED2] + report[GRADIENT2] + h.norm_sqr() + tau.sum())
        report[BAD] = ti.select(sound & (growth > 0.0), 0.0, 1.0)
        return report

    @ti.func
    def strained(strain2):
        """STRAINED of a particle with this |be - I|^2: 0 at SMALL_STRAIN, PARTS from LARGE_STRAIN on."""
        share = (ti.sqrt(strain2) - SMALL_STRAIN) / (LARGE_STRAIN - SMALL_STRAIN)
        return ti.floor(PARTS * ti.max(0.0, ti.min(share, 1.0)))

    @ti.func
    def add_row(reports: ti.template(), b, report: ti.template()):
        """Add row b to the report of all, which starts at zero."""
        for c in ti.static(range(N_REPORT)):
            if ti.static(c in SUMMED):
                report[c] += reports[b, c]
            elif reports[b, c] > report[c]:
                ti.atomic_max(report[c], reports[b, c])

    @ti.func
    def add_rows(reports: ti.template(), i, n, report: ti.template()):
        """Add partial sum i of n rows (`compiler.parallel`) to the report of all, which starts at zero."""
        if ti.static(in_order()):
            add_row(reports, i, report)
        else:
            found, step = ti.Vector.zero(ti.f64, N_REPORT), partial_sums(n)
            for k in range((n - 1 - i) // step + 1):
                for c in ti.static(range(N_REPORT)):
                    if ti.static(c in SUMMED):
                        found[c] += reports[i + k * step, c]
                    else:
                        found[c] = ti.max(found[c], reports[i + k * step, c])
            for c in ti.static(range(N_REPORT)):
                if ti.static(c in SUMMED):
                    report[c] += found[c]
                else:
                    ti.atomic_max(report[c], found[c])

    return SimpleNamespace(judge=judge, strained=strained, add_row=add_row, add_rows=add_rows)
