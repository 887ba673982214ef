"""Run-out by statistics of the path: the alpha-beta model.

    alpha = k1 beta + k2 z'' + k3 H0 + k4,   deviation SD

beta [degrees]: angle from the upper end of the path to the point where it first has 10 degrees or less over 30 m; z''
[1/m] and H0 [m]: second derivative and fall of the parabola of least squares through the profile; alpha: angle from the
upper end to the furthest point. Lied, Bakkehoi (1980), Journal of Glaciology 26 (94). Run-outs of alpha - n SD are
longer: by a normal distribution of what the fit leaves, one in 6 avalanches goes beyond alpha - SD, one in 44 beyond
alpha - 2 SD. The avalanches of such a fit are the longest known of their paths.
"""

import math
from dataclasses import dataclass

import numpy as np

from snowmpm.errors import InputError

BETA_SLOPE = 10.0
"""Slope of the beta point [degrees]."""
BETA_LENGTH = 30.0
"""Length over which it must be that gentle [m]."""
RUNOUTS = (1, 0, -1, -2)
"""Deviations whose run-outs are told."""
STEEP, STEEP_LENGTH = 20.0, 100.0
"""Ground that is this steep [degrees] over this length [m] beyond the beta point is another slope."""


@dataclass(frozen=True)
class Calibration:
    """k1 [-], k2 [degrees m], k3 [degrees/m], k4 [degrees], deviation [degrees]; source."""

    k1: float
    k2: float
    k3: float
    k4: float
    deviation: float
    source: str


CALIBRATIONS = {
    "austria": Calibration(1.05, -3130.0, 0.0, -2.38, 1.25, "Austria, standard, of com2AB in AvaFrame 2.1"),
    "austria_small": Calibration(0.933, 0.0, 0.0088, -5.02, 2.36, "Austria, small, of com2AB in AvaFrame 2.1"),
    "norway": Calibration(0.96, 0.0, 0.0, -1.4, 2.3, "Bakkehoi, Domaas, Lied (1983), Annals of Glaciology 4"),
}


@dataclass(frozen=True)
class AlphaBeta:
    """beta, alpha, deviation [degrees]; beta_s: length to the beta point [m]; runouts: length [m] by number of
    deviations (1, 0, -1, -2), None where the profile ends before; doubts: why the numbers may not hold."""

    beta: float
    beta_s: float
    alpha: float
    deviation: float
    runouts: dict[int, float | None]
    doubts: tuple[str, ...]


def alpha_beta(profile, calibration="austria", split=None):
    """`AlphaBeta` of a `Profile`. split [m]: beyond it the beta point is looked for; where the path becomes gentle by
    default. Raises InputError for an unknown calibration, and a path without a beta point."""
    if calibration not in CALIBRATIONS:
        raise InputError.not_in("--calibration", calibration, CALIBRATIONS)
    fit = CALIBRATIONS[calibration]
    if split is not None and split >= profile.s[-1]:
        raise InputError.at("--split", split, f"must be below the length of the path, {profile.s[-1]:.0f} m")
    split = profile.foot() if split is None else split
    i = _beta_point(profile, split)
    steep = _steep_again(profile, i)
    beta = math.degrees(math.atan2(profile.drop[i], profile.s[i]))
    a, b, c = profile.parabola
    heights = np.polyval([a, b, c], profile.s)
    fall = float(np.ptp(heights))
    alpha = fit.k1 * beta + fit.k2 * 2.0 * a + fit.k3 * fall + fit.k4
    if alpha + min(RUNOUTS) * fit.deviation <= 0.0:
        raise InputError(f"no alpha: {alpha:.1f} ± {fit.deviation:g} degrees, on a path that hardly falls")
    runouts = {n: profile.where_reached(profile.z[0] - profile.s * math.tan(math.radians(alpha + n * fit.deviation)),
                                        split) for n in RUNOUTS}
    doubts = [*_doubts(profile, alpha, beta, runouts, heights)]
    if steep is not None:
        doubts.append(f"beyond the beta point ({profile.s[i]:.0f} m) the path is steep again at {steep:.0f} m: if that"
                      " is the same slope, give --split there")
    return AlphaBeta(beta, float(profile.s[i]), alpha, fit.deviation, runouts, tuple(doubts))


def _steep_again(profile, i):
    """Length [m] at which a path is steep beyond point i, None where it is not."""
    steep = profile.fall_over(STEEP_LENGTH) >= STEEP_LENGTH * math.tan(math.radians(STEEP))
    falls = steep & (profile.s >= profile.s[i])
    return float(profile.s[np.flatnonzero(falls)[0]]) if falls.any() else None


def _beta_point(profile, split):
    """Number of the point that begins the first BETA_LENGTH of gentle ground beyond the split."""
    gentle = (profile.angles <= BETA_SLOPE) & (profile.s > split)
    pieces = np.diff(profile.s, prepend=0.0)
    i = 0
    while i < len(gentle):
        if not gentle[i]:
            i += 1
            continue
        j = i
        while j + 1 < len(gentle) and gentle[j + 1]:
            j += 1
        if pieces[i + 1 : j + 1].sum() >= BETA_LENGTH:
            return i
        i = j + 1
    raise InputError(f"no beta point: no {BETA_LENGTH:g} m of {BETA_SLOPE:g} degrees or less on the path beyond"
                     f" {split:.0f} m; a path must go on over the flat ground of its run-out")


def _doubts(profile, alpha, beta, runouts, heights):
    if alpha > beta:
        yield f"alpha = {alpha:.1f} is above beta = {beta:.1f} degrees: the calibration is not for such a path"
    if runouts[0] is None:
        yield "the path ends before alpha"
    elif runouts[-2] is None:
        yield "the path ends before alpha - 2 SD"
    off = float(np.abs(heights - profile.z).max())
    if off > 0.1 * profile.drop.max():
        yield f"a parabola fits the path badly: it is up to {off:.0f} m off"
