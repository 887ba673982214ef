"""Stability of a profile: critical cut length by theories, crack speed, whether the slab tears; with intervals.

    strength  a_c = L (sqrt(tau^2 + 2 sigma (tau_p - tau)) - tau) / sigma,  L = sqrt(E' D F_wl)     Gaume et al. (2017),
              doi:10.5194/tc-11-217-2017, Eq. 4, with F_wl of Richter et al. (2019), doi:10.5194/tc-13-3353-2019, as
              SNOWPACK has it: E of the mean density by Scapozza, tau_p by Jamieson & Johnston
    energy    dU/da = w_f on a rigid weak layer (`saw_test.theory.energy_of_cut`)                  Heierli et al. (2008)
    weac      dU/da = w_f on an elastic weak layer, where the package is installed             Rosendahl & Weissgraeber

The interval of each is what the scatter of the parametrisations makes of it: SAMPLES columns by a Latin hypercube,
between the quantiles INTERVAL. In these columns the law of the moduli is one of four by chance, whichever the value is
by. The share of each input in the variance of log a_c is its correlation ratio over BINS.
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from snowmpm.pit import mechanics
from snowmpm.pit.column import Column
from snowmpm.saw_test import theory, weac

SAMPLES, WEAC_SAMPLES = 96, 48
"""Columns of the intervals: WEAC takes every second."""
INTERVAL = 0.1, 0.9
BINS = 4
SEED = 20261129
CAP = 3.0
"""Longest critical length [m] that is given: beyond, the theory says that no saw test finds one."""
ANGLE_SCATTER = 2.0
"""Standard deviation of a measured slope angle [degrees]: chosen."""
FRICTION = 30.0
"""Friction angle of a crushed weak layer [degrees], about: van Herwijnen & Heierli (2009), doi:10.1029/2008GL036775."""
SIZE_SCATTER = 0.3
"""Standard deviation of the logarithm of a grain size: chosen; observers differ by a class."""
SPAN = 5.0
"""Length of the column of weac [m]: long, so that its far end does not count."""
INPUTS = ("slab density", "modulus law", "weak-layer density", "weak-layer strength", "collapse energy", "slope angle",
          "grain size")


@dataclass(frozen=True)
class Length:
    """Critical cut length [m] by one theory. value: None where it has none, and why; low, high: of its interval; share:
    of each of INPUTS in the variance of its logarithm; failing: share of samples in which the layer fails by itself."""

    theory: str
    value: float | None
    low: float | None = None
    high: float | None = None
    shares: tuple[float, ...] = ()
    why: str = ""
    failing: float = 0.0


@dataclass(frozen=True)
class Stability:
    """normal, shear: stress on the weak layer [Pa]; lengths; crack_speed [m/s], crack_way: words; tension: largest
    tensile stress in the slab as the crack begins to run, over its strength; None without a critical length; speeds,
    tensions: (low, high) of their intervals; tears: share of the columns whose slab tears, None without columns."""

    normal: float
    shear: float
    lengths: tuple[Length, ...]
    crack_speed: float
    crack_way: str
    tension: float | None
    speeds: tuple[float, float] | None = None
    tensions: tuple[float, float] | None = None
    tears: float | None = None

    def length(self, name: str) -> Length | None:
        return next((one for one in self.lengths if one.theory == name), None)

    @property
    def dominant(self) -> tuple[str, str, float] | None:
        """(theory, input, share): what the interval of the last theory that tells comes from most."""
        for one in reversed(self.lengths):
            if one.shares:
                k = int(np.argmax(one.shares))
                return one.theory, INPUTS[k], one.shares[k]
        return None

    @property
    def expected(self) -> float | None:
        """Critical length [m] of the last theory that has one."""
        return next((one.value for one in reversed(self.lengths) if one.value and one.value < CAP), None)


def stability_of(column: Column, samples: int = SAMPLES, use_weac: bool = True) -> Stability:
    """`Stability` of a column. samples: columns of the intervals, 0 for none; use_weac: where it is installed."""
    rows = hypercube(samples)
    columns = [sampled(column, row) for row in rows]
    lengths = [_length(name, critical, column, columns, rows)
               for name, critical in (("strength", by_strength), ("energy", by_energy))]
    if use_weac and weac.version():
        some = slice(0, None, max(1, math.ceil(len(rows) / WEAC_SAMPLES)))
        lengths.append(_length("weac", by_weac, column, columns[some], rows[some]))
    normal, shear = column.stresses
    speed, way = crack_speed(column)
    found = Stability(normal, shear, tuple(lengths), speed, way, None)
    cut = found.expected
    if cut is not None:
        found = replace(found, tension=tension(column, cut))
    if not columns:
        return found
    found = replace(found, speeds=_interval([crack_speed(one)[0] for one in columns]))
    if cut is None:
        return found
    tensions = [tension(one, cut) for one in columns]
    return replace(found, tensions=_interval(tensions), tears=float(np.mean(np.array(tensions) >= 1.0)))


def _interval(values):
    low, high = np.quantile(values, INTERVAL)
    return float(low), float(high)


def by_strength(column: Column) -> float | None:
    """Critical length [m] as SNOWPACK has it; 0 where the shear stress exceeds the strength; None without a law."""
    weak = column.weak
    if weak.strength is None:
        return None
    sigma, tau = column.stresses
    if tau >= weak.strength:
        return 0.0
    modulus = mechanics.youngs_modulus(column.density, "scapozza") / (1.0 - 0.2**2)
    reach = math.sqrt(modulus * column.thickness * mechanics.softness(weak.density, weak.size))
    return min(CAP, reach / sigma * (math.sqrt(tau**2 + 2.0 * sigma * (weak.strength - tau)) - tau))


def by_energy(column: Column) -> float:
    """Critical length [m] by the energy of the cut on a rigid weak layer."""
    sigma, tau = column.stresses
    if theory.energy_release_rate(column.slab, sigma, tau, CAP, "normal") < column.weak.energy:
        return CAP
    return theory.critical_length_by_energy(column.slab, sigma, tau, column.weak.energy, "normal")


def by_weac(column: Column) -> float | None:
    """Critical length [m] by WEAC; CAP where no cut is enough."""
    weak = column.weak
    return weac.critical_length_of(
        [(plate.thickness, plate) for plate in column.plates], weak, weak.thickness, slope_angle=column.angle,
        length=SPAN, ends="normal", energy=weak.energy) or CAP


def crack_speed(column: Column) -> tuple[float, str]:
    """Speed of a crack that runs [m/s], and how it runs: the collapse wave as long as the crushed layer holds the slab,
    the plate wave of the slab beyond (`theory.collapse_speed`, `theory.Slab.plate_speed`)."""
    if column.angle > FRICTION:
        return column.slab.plate_speed, f"shear, above {FRICTION:g} degrees"
    return theory.collapse_speed(column.slab, mechanics.collapse_height(column.weak.thickness)), "collapse"


def tension(column: Column, cut: float) -> float:
    """Largest tensile stress in the slab over a cut [m], over the tensile strength of its layer.

    The slab above the cut is a cantilever: at its root M = sigma a^2 / 2 bends it, N = tau a stretches it. In a layer
    of modulus E' whose upper face is z above the neutral axis the stress is E' (M z / B + N / A). From 1 on the slab
    tears before the crack can run far: a slab fracture of the saw test.
    """
    sigma, tau = column.stresses
    slab, D = column.slab, column.thickness
    bending, stretching = slab.bending_modulus * D**3 / 12.0, slab.stretching_modulus * D
    moduli = [plate.youngs_modulus / (1.0 - plate.poisson_ratio**2) for plate in column.plates]
    tops = np.cumsum([plate.thickness for plate in column.plates])
    middles = tops - 0.5 * np.array([plate.thickness for plate in column.plates])
    neutral = sum(E * plate.thickness * z for E, plate, z in zip(moduli, column.plates, middles, strict=True)
                  ) / stretching
    moment, force = 0.5 * sigma * cut**2, tau * cut
    return float(max(E * (moment * (top - neutral) / bending + force / stretching)
                     / mechanics.tensile_strength(plate.density)
                     for E, plate, top in zip(moduli, column.plates, tops, strict=True)))


def hypercube(n):
    """(n, inputs) normal deviates; the law of moduli as a uniform number."""
    if not n:
        return np.zeros((0, len(INPUTS)))
    from scipy.stats import norm

    from snowmpm.campaigns import design

    uniform = design.shares("latin_hypercube", n, len(INPUTS), SEED)
    rows = norm.ppf(uniform)
    rows[:, INPUTS.index("modulus law")] = uniform[:, INPUTS.index("modulus law")]
    return rows


def sampled(column, row):
    """The column of one row of the `hypercube`."""
    of = dict(zip(INPUTS, row, strict=True))
    laws = [*mechanics.MODULI]
    law = laws[int(of["modulus law"] * len(laws))]

    def dense(rho, source, name):
        return float(np.clip(rho * math.exp(mechanics.DENSITY_SCATTER[source] * of[name]), 20.0, 900.0))

    plates = []
    for plate in column.plates:
        rho = dense(plate.density, plate.source, "slab density")
        plates.append(replace(plate, density=rho, youngs_modulus=mechanics.youngs_modulus(rho, law)))
    weak = column.weak
    rho = dense(weak.density, weak.source, "weak-layer density")
    strength = None
    if weak.strength is not None:  # it follows the density by its own law
        strength = weak.strength * (rho / weak.density) ** weak.strength_exponent * math.exp(
            mechanics.STRENGTH_SCATTER * of["weak-layer strength"])
    energy = weak.energy * math.exp(mechanics.COLLAPSE_SCATTER * of["collapse energy"])
    return replace(
        column, plates=tuple(plates), angle=float(np.clip(column.angle + ANGLE_SCATTER * of["slope angle"], 0.0, 80.0)),
        weak=replace(weak, density=rho, youngs_modulus=mechanics.youngs_modulus(rho, law), strength=strength,
                     energy=energy, size=weak.size * math.exp(SIZE_SCATTER * of["grain size"])))


def _length(name, critical, column, columns, rows):
    value = critical(column)
    if value is None:
        return Length(name, None, why="no law of strength for this grain form")
    why = "would fail under the weight of the slab alone" if value == 0.0 else (
        f"longer than {CAP:g} m" if value >= CAP else "")
    if not len(columns):
        return Length(name, value, why=why)
    found = np.array([critical(one) for one in columns])
    low, high = np.quantile(found, INTERVAL)
    return Length(name, value, float(low), float(high), variance_shares(found, rows), why, float(np.mean(found == 0.0)))


def variance_shares(found, rows):
    """Correlation ratio of log a_c with each input: variance of the means of BINS equal bins over the whole variance,
    less what chance gives, (BINS - 1) / (n - 1)."""
    log, n = np.log(np.maximum(found, 0.01)), len(found)
    if not log.var() > 0.0 or n < 4 * BINS:
        return ()
    chance = (BINS - 1) / (n - 1)
    shares = []
    for column in rows.T:
        parts = np.array_split(log[np.argsort(column)], BINS)
        between = sum(len(part) * (part.mean() - log.mean()) ** 2 for part in parts) / n / log.var()
        shares.append(float(max(0.0, (between - chance) / (1.0 - chance))))
    return tuple(shares)
