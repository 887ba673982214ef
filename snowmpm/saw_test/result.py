"""Results of a saw test, as field studies report them, from its record.

Each number has one of three answers: a value; that it did not happen; or that the record cannot tell, since the column
or the run was too short for it. What is no value has its reason, which begins with one of `quantities.saw.REASONS`.
"""

from dataclasses import dataclass

import numpy as np

from snowmpm.quantities.saw import COLUMN_TOO_SHORT, NOT_HAPPENED, RUN_TOO_SHORT, VOID

RUNAWAY = 3.0
"""Speed over that of the saw above which a crack counts as self-propagating."""

AHEAD = 2.0
"""Way over the thickness D of the slab over which a crack must run on to count as such, where the column has it."""

LEFT = 0.5
"""Smallest share of the column that must be ahead of a crack that has not that much."""

END = 0.1
"""Largest share of the column, beside D, by which the tip may be short of the far end for a crack that came there."""

STEADY, FREE_END = 2.0, 2.0
"""Lengths, over D, at the begin of a crack's own path and before its end, whose speed is not that of a steady crack."""

BROKEN_BEFORE = 0.01
"""Largest share of the column that may have broken before the saw began, for instance at its free ends."""

STANDS = 3.0
"""Number of bins that would have broken, at the crack's speed, since its tip stands still: from there on it has
stopped."""

FALLS = 4.0
"""Number of intervals of the record by which a bin must break before bins nearer to the saw to belong to another
crack."""

SLACK = 1e-9
NAMES = ("critical_length", "critical_length_resolution", "stopped", "crack_speed", "crack_speed_spread", "top_speed",
         "collapse_height", "fracture_energy")
EXPLAINED = ("critical_length", "crack_speed", "top_speed", "collapse_height", "fracture_energy")


@dataclass(frozen=True)
class Column:
    """What is known of a saw test: D, width of a bin, length [m]; fast: speed of a runaway crack [m/s]; row: interval
    of the record [s]; tip and cut at the end [m]."""

    values: dict
    D: float
    saw_speed: float

    @property
    def x(self):
        """Middles of the bins (n,) [m]."""
        return self.values["x"]

    @property
    def arrival(self):
        """Time (n,) at which each bin broke [s]."""
        return self.values["arrival"]

    @property
    def width(self):
        """Of a bin [m]."""
        return float(self.x[1] - self.x[0]) if len(self.x) > 1 else 2.0 * float(self.x[0])

    @property
    def length(self):
        """Of the column [m]."""
        return float(self.x[-1]) + 0.5 * self.width

    @property
    def fast(self):
        """Speed above which a crack runs by itself [m/s]."""
        return RUNAWAY * self.saw_speed

    @property
    def row(self):
        """Interval of the record [s]."""
        return float(np.median(np.diff(self.values["time"]))) if len(self.values["time"]) > 1 else 0.0

    @property
    def tip(self):
        """Tip of the crack at the end [m]."""
        return float(self.values["tip"][-1])

    @property
    def cut(self):
        """Cut at the end [m]."""
        return float(self.values["saw"][-1])

    @property
    def sawn(self):
        """Whether the saw had begun, and stood still when the record ended."""
        saw = self.values["saw"]
        return bool(saw[-1] > saw[0] and saw[-1] - saw[max(-2, -len(saw))] < 0.5 * self.saw_speed * self.row)

    @property
    def far_end(self):
        """Place beyond which a crack has come to the far end [m]."""
        return float(self.x[-1]) - min(self.D, END * self.length)

    def cut_at(self, time):
        """Length of the cut at a time [m]."""
        return float(np.interp(time, self.values["time"], self.values["saw"]))


def result_of(values, *, slab_thickness, saw_speed):
    """Results of a saw test, by name; None where there is none, and in `reasons` why.

    values: `CrackRecord.values()`, or the same arrays from a run file. Lengths along the column from the saw's end [m];
    a is critical_length, e the end of the crack:

    critical_length     length of the cut when the crack began to run by itself: from there it runs on for 2 D, twice
                        the thickness of the slab, over this length and over its first 0.1 m faster than `RUNAWAY` times
                        the saw. It may still arrest later: see runs_to_the_end. In a column that has not 2 D left, the
                        tip must leave the saw and come to the far end, as fast over each 0.1 m, and at least half of
                        the column must have been left for it
    critical_length_resolution  to which it is known: the width of a bin
    crack_length        tip of the crack at the end; runs_to_the_end: it is within D, and within a tenth of the column,
                        of the far end
    stopped             the tip stands still short of the far end, although at crack_speed `STANDS` bins would have
                        broken since; None where no crack ran
    crack_speed         [m/s] median over windows of length D between a + 2 D, or a D before halfway, and e - 2 D. Near
                        the saw the crack accelerates, near the free end it jumps. Windows in which bins broke ahead of
                        the tip do not count, unless they are more than half
    crack_speed_spread  [m/s] half of the range of these speeds from 1/6 to 5/6 of them; at least v^2 dt / D, which rows
                        of the record dt apart resolve
    top_speed           [m/s] exceeded, over windows of length D between a + D and e - 2 D, on a tenth of the path
    collapse_height     median settlement of the slab at the end, from 2 D beyond both a and the end of the saw's cut to
                        2 D behind the tip
    fracture_energy     [J/m2] median work in the weak layer per area until it has lost its strength, from a + D to 2 D
                        behind the tip
    plastic_work        [J] of all snow at the end, per metre of width in 2-D
    broken_at_rest      share of the column whose weak layer had broken before the saw began. Above `BROKEN_BEFORE`
                        the test is void: the other numbers are None
    reasons             {name: text} of the numbers that are None
    """
    column = Column(values, slab_thickness, saw_speed)
    found = {**dict.fromkeys(NAMES), "crack_length": column.tip, "runs_to_the_end": bool(column.tip > column.far_end),
             "plastic_work": float(values["plastic_work"][-1]),
             "broken_at_rest": float(np.mean(values["broken_at_rest"])) if "broken_at_rest" in values else 0.0}
    if found["broken_at_rest"] > BROKEN_BEFORE:
        share = f"{found['broken_at_rest']:.0%}"
        return _explained(found, f"{VOID}: the weak layer had broken over {share} of the column before the saw began")
    first, late = onset(column)
    if first is None:
        return _explained(found, _why_none(column, late))
    return _of_crack(column, first, found)


def _explained(found, reason):
    return {**found, "reasons": dict.fromkeys(EXPLAINED, reason)}


def _of_crack(column, first, found):
    """Numbers of a crack that runs by itself from bin `first`."""
    x, arrival, values, D = column.x, column.arrival, column.values, column.D
    found["critical_length"] = column.cut_at(arrival[first])
    found["critical_length_resolution"] = column.width
    own = (np.arange(len(x)) >= first) & (x < column.tip) & np.isfinite(arrival)
    passed, reached = _front(arrival, first, FALLS * column.row)
    reached &= own
    start, end = float(x[first]), float(x[reached][-1]) if reached.any() else float(x[first])
    found |= _speeds(column, passed, reached, start, end)
    duration = max(float(np.max(passed[reached], initial=arrival[first])) - arrival[first], column.row, 1e-300)
    pace = found["crack_speed"] or (end - start) / duration
    found["stopped"] = bool(not found["runs_to_the_end"] and still(values, pace) > STANDS * column.width)
    sawn = max(start, column.cut)
    for name, begin, measured in (("collapse_height", sawn + 2.0 * D, values["settlement"][-1]),
                                  ("fracture_energy", start + D, values["fracture_energy"])):
        inside = own & (x > begin) & (x < column.tip - 2.0 * D) & np.isfinite(measured)
        found[name] = float(np.median(measured[inside])) if inside.any() else None
    # A bin more at either end: windows begin and end at bins
    run = start + (STEADY + 1.0 + FREE_END) * D + 2.0 * column.width
    needs = {"crack_speed": run, "top_speed": run, "collapse_height": sawn + 4.0 * D + column.width,
             "fracture_energy": start + 3.0 * D + column.width}
    found["reasons"] = {name: _too_short(column, found, need) for name, need in needs.items() if found[name] is None}
    return found


def _speeds(column, passed, reached, start, end):
    """Speeds of a crack whose own path goes from `start` to `end` [m]."""
    x, D, half = column.x, column.D, 0.5 * column.D
    middle, speed = crack_speed(x[reached], passed[reached], D)
    last = end - FREE_END * D
    begin = max(start + STEADY * D, 0.5 * (start + last) - half)
    ahead = x[reached][column.arrival[reached] < passed[reached] - FALLS * column.row]
    jumped = (np.abs(middle[:, None] - ahead[None, :]) <= half).any(axis=1)
    before_end = np.isfinite(speed) & (middle + half <= last + SLACK)
    steady = before_end & (middle - half >= begin - SLACK)
    if (steady & ~jumped).sum() >= 0.5 * steady.sum():
        steady &= ~jumped
    if not steady.any():
        return {}
    low, v, high = np.quantile(speed[steady], (1.0 / 6.0, 0.5, 5.0 / 6.0)).tolist()
    path = before_end & (middle - half >= start + D - SLACK) & (~jumped | steady)
    return {"crack_speed": v, "crack_speed_spread": max(0.5 * (high - low), v**2 * column.row / D),
            "top_speed": float(np.percentile(speed[path], 90.0))}


def _too_short(column, found, need):
    """Why a number is not known that needs a crack up to `need` [m]."""
    if found["runs_to_the_end"] and need <= column.length:
        return f"{COLUMN_TOO_SHORT}: the crack did not run steadily over {need:.2f} of {column.length:.2f} m"
    if found["runs_to_the_end"]:
        return f"{COLUMN_TOO_SHORT}: needs {need:.2f} m, has {column.length:.2f} m"
    if found["stopped"]:
        return f"{NOT_HAPPENED}: the crack stopped at {column.tip:.2f} m, before it had run {need:.2f} m"
    return (f"{RUN_TOO_SHORT}: the crack was at {column.tip:.2f} m when the run ended, and has to come to"
            f" {need:.2f} m")


def _why_none(column, late):
    """Why there is no critical length. late: bin from which a crack ran that had too little of the column left."""
    to_the_end = column.tip > column.far_end and column.length < 2.0 * AHEAD * column.D
    sawn_through = column.cut > column.length - AHEAD * column.D - column.width
    if late is not None or (to_the_end and sawn_through):
        at = "" if late is None else f", at a cut of {column.cut_at(column.arrival[late]):.2f} m"
        return f"{COLUMN_TOO_SHORT}: the slab broke the rest of it{at}, before a crack had room to run by itself"
    if _on_its_way(column):
        return f"{RUN_TOO_SHORT}: the crack, at {column.tip:.2f} m, was on its way when the run ended"
    if not column.sawn:
        return f"{RUN_TOO_SHORT}: the saw, at {column.cut:.2f} m, had not come to its end when the run ended"
    return f"{NOT_HAPPENED}: no crack ran by itself, with a cut of {column.cut:.2f} m"


def _on_its_way(column):
    """Whether the bins that broke last did so fast, and just before the end of the record."""
    x, arrival, width = column.x, column.arrival, column.width
    newest = arrival[np.isfinite(arrival) & (x > column.tip - 0.1 - 2.0 * width) & (x < column.tip)]
    way = width * (len(newest) - 1)
    if way <= 0.0 or column.tip > column.far_end:
        return False
    waited = column.values["time"][-1] - newest.max()
    return way > column.fast * np.ptp(newest) and column.fast * waited < STANDS * width


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


def onset(column):
    """(first bin from which the crack runs by itself, first from which it does so with too little of the column left);
    None for each that is not. column: `Column`."""
    arrival, width = column.arrival, column.width
    steps = np.array([max(1, round(0.1 / width)), max(2, round(AHEAD * column.D / width))])
    last, late = int(np.searchsorted(column.x, column.far_end - SLACK)), None
    for i in np.flatnonzero(np.isfinite(arrival)):
        if i + steps[1] < len(arrival):
            times = arrival[i + steps] - arrival[i]
            if (np.isfinite(times) & (times * column.fast < steps * width)).all():
                return i, None
        elif i + steps[0] <= last and _runs_out(column, arrival[i : last + 1], steps[0]):
            if column.length - (column.x[i] - 0.5 * width) >= LEFT * column.length:
                return i, None
            late = i if late is None else late
    return None, late


def _runs_out(column, arrival, near):
    """Whether bins up to the far end broke one after the other, fast over each `near` of them."""
    if not np.isfinite(arrival).all():
        return False
    paces, jumps = arrival[near:] - arrival[:-near], np.maximum.accumulate(arrival) - arrival
    return bool((paces * column.fast < near * column.width).all() and (jumps <= FALLS * column.row).all())
