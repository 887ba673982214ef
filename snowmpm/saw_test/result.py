"""Results of a saw test, as field studies report them, from its record."""

import numpy as np

RUNAWAY = 3.0
"""Speed over that of the saw above which a crack counts as self-propagating."""

BROKEN_BEFORE = 0.01
"""Largest share of the column that may have broken before the saw began, for instance at its free ends."""

STANDS = 3.0
"""Number of bins that would have broken, at the crack's speed, since its tip stands still: from there on it has
stopped."""

FALLS = 4.0
"""Number of intervals of the record by which a bin must break before bins nearer to the saw to belong to another
crack."""


def result_of(values, *, slab_thickness, saw_speed):
    """Results of a saw test, by name; None if the crack did not get that far.

    values: `CrackRecord.values()`, or the same arrays from a run file. Lengths along the column from the saw's end [m]:

    critical_length     length of the cut when the crack began to run by itself: from there it runs on for 2 D, twice
                        the thickness of the slab, over this length and over its first 0.1 m faster than `RUNAWAY` times
                        the saw. It may still arrest later: see runs_to_the_end
    critical_length_resolution  width of a bin, to which it is known
    crack_length        tip of the crack at the end; runs_to_the_end: it is within D of the far end
    stopped             the tip stands still short of the far end, although at crack_speed `STANDS` bins would have
                        broken since; None where no crack ran
    crack_speed         [m/s] median over windows of length D from halfway to D before the end of the crack
    crack_speed_spread  [m/s] half of the range of these speeds from 1/6 to 5/6 of them; at least v^2 dt / D, which rows
                        of the record dt apart resolve
    top_speed           [m/s] exceeded, over windows of length D, on a tenth of the path
    collapse_height     median settlement of the slab at the end, where the crack ran by itself and its tip is 2 D
    further
    fracture_energy     [J/m2] median work in the weak layer per area until it has lost its strength, at the same places
    plastic_work        [J] of all snow at the end, per metre of width in 2-D
    broken_at_rest      share of the column whose weak layer had broken before the saw began. Above `BROKEN_BEFORE`
                        the test is void: the other numbers are None
    """
    x, arrival, time = values["x"], values["arrival"], values["time"]
    D, width = slab_thickness, x[1] - x[0] if len(x) > 1 else x[0]
    tip = float(values["tip"][-1])
    first = onset(x, arrival, D, RUNAWAY * saw_speed, width)
    found = {"critical_length": None, "critical_length_resolution": None, "crack_length": tip,
             "runs_to_the_end": bool(tip > x[-1] - D), "stopped": None, "crack_speed": None, "crack_speed_spread": None,
             "top_speed": None, "collapse_height": None, "fracture_energy": None,
             "plastic_work": float(values["plastic_work"][-1])}
    found["broken_at_rest"] = float(np.mean(values["broken_at_rest"])) if "broken_at_rest" in values else 0.0
    if first is None or found["broken_at_rest"] > BROKEN_BEFORE:
        return found
    found["critical_length"] = float(np.interp(arrival[first], time, values["saw"]))
    found["critical_length_resolution"] = float(width)
    own = (np.arange(len(x)) >= first) & (x < tip) & np.isfinite(arrival)
    begun = first + max(1, round(D / width))  # nearer, bins break almost at once
    row = float(np.median(np.diff(time)))
    passed, one = _front(arrival, first, FALLS * row)
    one &= own
    middle, speed = crack_speed(x[one], passed[one], D)
    ahead = np.isfinite(speed)
    if ahead.any():
        ahead &= middle > 0.5 * (x[first] + x[one][-1])
    if ahead.any():
        low, v, high = np.quantile(speed[ahead], (1.0 / 6.0, 0.5, 5.0 / 6.0)).tolist()
        found |= {"crack_speed": v, "crack_speed_spread": max(0.5 * (high - low), v**2 * row / D)}
        found["stopped"] = bool(not found["runs_to_the_end"] and still(values, v) > STANDS * width)
        found["top_speed"] = float(np.nanpercentile(speed[(middle > x[begun]) | ahead], 90.0))
    settled = own & (x < tip - 2.0 * D) & (x > x[first] + D)
    if settled.any():
        found["collapse_height"] = float(np.nanmedian(values["settlement"][-1][settled]))
        found["fracture_energy"] = float(np.nanmedian(values["fracture_energy"][settled]))
    return found


def still(values, speed):
    """Way [m] that a crack of this speed [m/s] would have gone since the tip stands still at the end of the record."""
    tip, time = values["tip"], values["time"]
    moved = np.flatnonzero(np.diff(tip) > 0.0)
    since = time[moved[-1] + 1] if len(moved) else time[0]
    return float(speed * (time[-1] - since))


def _front(arrival, first, tolerance):
    """Time (n,) at which all bins from `first` to each bin were broken, and which bins the crack from there has
    reached. A crack that starts ahead of it, as in its own shear waves, belongs to it once it catches up; a crack from
    the far end of the column does not.
    """
    passed = np.where(np.isfinite(arrival), arrival, -np.inf)
    passed[first:] = np.maximum.accumulate(passed[first:])
    reached = np.flatnonzero(arrival >= passed - tolerance)
    return passed, np.arange(len(arrival)) <= reached.max(initial=-1)


def crack_speed(x, arrival, length):
    """Crack length [m] and the speed [m/s] at it, over windows of `length` [m]; negative or zero times give NaN."""
    known = np.isfinite(arrival)
    x, arrival = x[known], arrival[known]
    if len(x) < 3:
        return np.zeros(0), np.zeros(0)
    first = np.searchsorted(x, x - 0.5 * length)
    last = np.minimum(np.searchsorted(x, x + 0.5 * length), len(x) - 1)
    whole = (x - 0.5 * length >= x[0]) & (x + 0.5 * length <= x[-1])
    duration = arrival[last] - arrival[first]
    with np.errstate(divide="ignore", invalid="ignore"):
        speed = np.where(duration > 0.0, (x[last] - x[first]) / duration, np.nan)
    return x[whole], speed[whole]


def onset(x, arrival, D, faster_than, width):
    """First bin from which the crack runs by itself; None where there is none."""
    near, far = max(1, round(0.1 / width)), max(2, round(2.0 * D / width))
    for i in np.flatnonzero(np.isfinite(arrival[: len(x) - far])):
        times = arrival[[i + near, i + far]] - arrival[i]
        if (np.isfinite(times) & (times * faster_than < np.array([near, far]) * width)).all():
            return i
    return None
