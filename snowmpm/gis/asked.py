"""What a user asks of a run besides its maps: scores against an observed outline, gauges, numbers along a path."""

import warnings
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from snowmpm import overwriting
from snowmpm.io.along_path import along_path, extended

ROUGH = 0.05
"""Difference of the volume by the frames from that by the steps, over all that crossed the line either way, above which
the discharge is warned of."""


@dataclass(frozen=True)
class Asked:
    """outline: the `Observed` one, or None, and its scores; gauges: `snowmpm.io.gauges.Gauge`s; along: numbers along a
    path, {} without one; path: name and corners (n, 2) of the path that was given, None of the thalweg."""

    outline: Any = None
    scores: list | None = None
    gauges: list = field(default_factory=list)
    along: dict = field(default_factory=dict)
    path: tuple | None = None

    @property
    def places(self):
        """(name, corners (n, 2)) of what a map shows: the gauges, and the path that was given."""
        return [*((one.place.name, one.place.corners) for one in self.gauges), *([self.path] if self.path else [])]


def asked_of(run, observed=None, gauges=None, path=None):
    """`Asked` of a `Run`, by vector files (paths or None). InputError for what they must not be; warnings for what is
    left out of them, and for gauges whose discharge the frames do not resolve."""
    along, given = _along(run, path)
    outline, scores = _observed(run, observed, given and given[1]) if observed else (None, None)
    return Asked(outline, scores, _gauges(run, gauges) if gauges else [], along, given)


def _observed(run, path, line):
    from snowmpm.gis.observed import read_observed, score

    overwriting.reads(path)
    outline = read_observed(path, run)
    return outline, score(run, outline, line)


def _gauges(run, path):
    from snowmpm.gis.lines import read_places
    from snowmpm.io.gauges import gauges

    overwriting.reads(path)
    found = gauges(run, read_places(path, run), f"--gauges = {str(path)!r}")
    rough = [repr(one.place.name) for one in found if one.place.is_line and abs(
        one.numbers["gauge_frames"] - one.numbers["gauge_volume"]) > ROUGH * one.numbers["gauge_both_ways"]]
    if rough:
        warnings.warn(f"--gauges: across {', '.join(rough)} the frames add up to another volume than the steps"
                      " (gauge_frames): their discharge is doubtful, since frames are too far apart (output.interval)"
                      " or the ground is steep. The volume of the steps holds.", stacklevel=2)
    return found


def _along(run, path):
    """Numbers along a path, and the path that was given."""
    profile = run.hazard.get("profile")
    if run.terrain is None or "peak_pressure" not in run.maps or not (path or profile):
        return {}, None
    if path is None:
        line, where = extended(profile), f"{run.path}: its thalweg"
    else:
        from snowmpm.gis.lines import read_path

        overwriting.reads(path)
        line, where = read_path(path, run), f"--path = {str(path)!r}"
    numbers, beyond = along_path(run.maps, run.origin[:2], line, lambda places: run.terrain.heights(
        places - run.origin[:2]) + run.origin[2], where)
    if beyond:
        warnings.warn(f"{where}: the peak pressure is above 1 kPa at its end: its run-out is the length of the path",
                      stacklevel=2)
    return numbers, (Path(path).name, line) if path else None
