"""The largest stable step and what limits it.

    elastic      dt <= C dx / c,     c = c_0 sqrt(1 + e),  c_0 = sqrt(t M / rho_0),  M = K + 4G/3
    advective    dt <= C dx / |v|
    deformation  dt <= 0.3 / |grad v|,  0.8 / |grad v| for snow without stress

with e the largest elastic compression (Hencky strain): the speed of a wave seen on the grid is sqrt(M (1 - ln F) /
rho_0), hence the factor sqrt(1 + e). t is 1, or what a law whose flow is not normal is stiffer by while it yields
(`Law.tangent_over_elastic`). Laws that stiffen (`Law.stiffness`) report the c of their state, if it is larger.

Least stable is a grain alone on its nodes, not a body: no set of particles on a lumped grid has a frequency above that
of its stiffest particle by itself (eigenvalues of a sum of elements). With all nodes of the stencil in their places, a
stress tau of a grain gives it the velocity gradient -dt tau G / rho_0, G = sum_i grad w grad w^T / w, hence

    omega^2 = M s g / (rho_0 dx^2),   g = 1 / D (gradient "affine"), at most 6 or 3.13 (gradient "shape"),
    s = largest eigenvalue of the stiffness / M,   2-D 1 / (1 - nu),  3-D (1 + nu) / (1 - nu)  for nu >= 0

since it swells along all axes at once, where a wave moves along one. Of gimp and linear g is at most 9.33 and 65.
Transfers that hand C on keep what the grain does from step to step, omega dt <= 2; in PIC and FLIP the grid starts anew
from v alone, omega dt <= sqrt(2). A body filled with particles bears 1.2 to 1.8 times that, but the first grain torn
off would blow up in it.

A body that crosses half a cell or a whole one in each step is as stable as one at rest: the advective limit is one of
accuracy, and of how far the blocks of the grid can follow. Deformation: free elastic blocks that collapse, swell or
shear hold together and gain no energy up to |dt grad v| = 0.45 at least, and first fail at 0.5
(tests/benchmarks/deformation_step.py). That limit is not scaled by cfl, nor stretched for fixed steps.
"""

import math
from dataclasses import dataclass

from snowmpm.schemes import TRANSFERS, Transfer


@dataclass(frozen=True)
class Critical:
    """Largest stable C sqrt(s): with transfers that hand C on (APIC, AFLIP; NaN of a basis that goes with none of
    them), and without (PIC, FLIP at any ratio)."""

    affine: float
    plain: float

    def of(self, transfer: Transfer) -> float:
        """The one of a `schemes.Transfer`."""
        return self.affine if transfer.affine else self.plain


CRITICAL = {
    ("quadratic", "affine"): Critical(1.0, 0.707),
    ("quadratic", "shape"): Critical(0.707, 0.577),
    ("cubic", "affine"): Critical(1.154, 0.816),
    ("cubic", "shape"): Critical(1.105, 0.798),
    ("gimp", "shape"): Critical(math.nan, 0.463),
    ("linear", "shape"): Critical(math.nan, 0.175),
}
"""Largest stable C sqrt(s) of each basis and gradient.

Measured to 1 % by tests/benchmarks/critical_step.py at a lone grain in the worst place of a cell, in 2-D and 3-D; full,
sparse, random, squeezed, hardened bodies, at walls or passing through the grid, bear at least as much."""

USUAL_SHARE = 0.9
"""The C of the elastic limit over the critical one, of a scene that gives none. Errors do not grow with the step where
nothing softens (`snowmpm study accuracy-speed`), and no grain bears less than the critical one, known to 1 %."""

USUAL_ADVECTIVE = 0.4
"""Cells that a particle may cross in a step of a scene that gives no C: paths and what walls take depend on it."""

SMALL_STRAIN, LARGE_STRAIN = 0.1, 0.2
"""|be - I| up to which the elastic limit takes the usual C, as the critical one is that of small strains, and from
which on it takes `BREAKING_CFL`. Snow that flows comes to 0.09 (slab_release_resolved); bars stretched to twice their
length and blocks pressed to a third are beyond. Between them C falls in a straight line: steps that jump between two
lengths shake what they compute."""

BREAKING_CFL = 0.4
"""The C of the elastic limit while bonds break or strains are large, where that is less: the error in the work that a
crack takes grows with the strain of a step. With 0.2 it is a third less, at twice the steps."""

STRAINED_SHARE = 0.02
"""Of all particles that must be beyond LARGE_STRAIN, or twice as many halfway to it, before C falls as their largest
strain says; fewer let it fall in proportion. Snow that squeezes through a gully leaves the step alone: with a
thousandth instead, an avalanche takes 1.16 times as many steps, and its run-out differs by 0.7 %, its maps of peak
depth and pressure by 3 and 4 %, as they do between any two lengths of the step. The wave of the largest keeps it
stable."""

BREAKING_SHARE = 1e-3
"""Of the particles that bonds held at the start: fewer that break are stragglers, and leave the step alone."""

DEFORMATION_LIMIT = 0.3
"""Largest |dt grad v| of a step (Frobenius norm): f = I + dt grad v must not turn a particle inside out."""

FREE_LIMIT = 0.8
"""The same for a grain that carries no stress: only its volume follows from it, to |dt grad v|^3 / 6 a step. One grain
in the air would else set the step of all. Below 1 I + dt grad v cannot turn it inside out."""

FLIGHT_LIMIT = 1.0
"""Cells that a particle may cross in a fixed step: the grid of blocks can follow no more than that."""


@dataclass(frozen=True)
class Extremes:
    """What a step leaves behind for the choice of the next one."""

    speed: float = 0.0
    """Largest particle speed [m/s]."""
    gradient: float = 0.0
    """Largest |grad v| [1/s]; that of grains without stress counts DEFORMATION_LIMIT / FREE_LIMIT of it."""
    elastic_deviation: float = 0.0
    """Largest |be - I| [-]."""
    strained: float = 1.0
    """What all particles count beyond SMALL_STRAIN (1 each from LARGE_STRAIN on) over STRAINED_SHARE of their number,
    at most 1."""
    wave_speed: float = 0.0
    """Largest wave speed of the laws that stiffen, at their present state [m/s]."""
    breaking: int = 0
    """Particles that lost bonds and have some left."""


def grain_stiffness(law, dim):
    """s [-]: largest eigenvalue of a law's elastic stiffness over M, at least 1 for a wave along one axis."""
    K, G = law.bulk_modulus, law.shear_modulus
    swelling = 3.0 * K if dim == 3 else 2.0 * (K + G / 3.0)
    return max(1.0, max(swelling, 2.0 * G) / (K + 4.0 / 3.0 * G))


def critical_cfl(kernel, gradient, transfer, stiffness):
    """Largest stable C = c dt / dx of a scheme; stiffness: the s of `grain_stiffness`, of all materials the largest."""
    return CRITICAL[kernel, gradient].of(TRANSFERS[transfer]) / math.sqrt(stiffness)


def usual_cfl(critical):
    """C of a scene that leaves it to the program, while no bonds break."""
    return USUAL_SHARE * critical


def strained_cfl(usual, careful, deviation, strained=1.0):
    """C of the elastic limit at this largest |be - I|: from `usual` at SMALL_STRAIN to `careful` at LARGE_STRAIN.

    strained: the most of this way that it goes (`Extremes.strained`).
    """
    share = (deviation - SMALL_STRAIN) / (LARGE_STRAIN - SMALL_STRAIN)
    return usual + min(max(share, 0.0), strained) * (careful - usual)


def stable_step(dx, elastic, advective, wave_speed, extremes):
    """-> (dt [s], cause): the smallest of the three limits.

    elastic, advective: C of these limits [-]; wave_speed: largest c_0 of the materials [m/s].
    """
    wave_speed = max(wave_speed, extremes.wave_speed)
    compression = -0.5 * math.log(max(1.0 - extremes.elastic_deviation, 0.01))
    limits = {
        "elastic": elastic * dx / (wave_speed * math.sqrt(1.0 + compression)),
        "advective": advective * dx / extremes.speed if extremes.speed > 0.0 else math.inf,
        "deformation": DEFORMATION_LIMIT / extremes.gradient if extremes.gradient > 0.0 else math.inf,
    }
    cause = min(limits, key=lambda name: limits[name])
    return limits[cause], cause
