"""What a user asks of a run besides its maps: scores against an observed outline, gauges, numbers along a path."""

import warnings
from dataclasses import dataclass, field
from typing import Any

from snowmpm import overwriting
from snowmpm.results.along_path import along_path, along_thalweg

ROUGH = 0.1
"""Difference of the volume of the frames from that of the steps, above which the discharge is warned of."""


@dataclass(frozen=True)
class Asked:
    """outline: the `Observed` one, or None, and its scores; gauges: `snowmpm.io.gauges.Gauge`s; along: numbers along
    the path that is given, else along the thalweg, {} without one."""

    outline: Any = None
    scores: list | None = None
    gauges: list = field(default_factory=list)
    along: dict = field(default_factory=dict)


def asked_of(run, observed=None, gauges=None, path=None):
    """`Asked` of a `Run`, by vector files (paths or None). InputError for what they must not be; warnings for what is
    left out of them, and for gauges whose discharge the frames do not resolve."""
    outline, scores = _observed(run, observed) if observed else (None, None)
    return Asked(outline, scores, _gauges(run, gauges) if gauges else [], _along(run, path))


def _observed(run, path):
    from snowmpm.gis.observed import read_observed, score

    overwriting.reads(path)
    outline = read_observed(path, run)
    return outline, score(run, outline)


def _gauges(run, path):
    from snowmpm.gis.lines import read_places
    from snowmpm.io.gauges import gauges

    overwriting.reads(path)
    found = gauges(run, read_places(path, run))
    rough = [one.place.name for one in found if abs(one.numbers.get("gauge_scaled", 1.0) - 1.0) > ROUGH]
    if rough:
        warnings.warn(f"--gauges: across {', '.join(rough)} the frames add up to another volume than the steps, by"
                      " which their discharge is scaled (gauge_scaled): they are too far apart (output.interval), or"
                      " the ground is steep. The volume holds.", stacklevel=2)
    return found


def _along(run, path):
    if path is None:
        profile = run.hazard.get("profile")
        return along_thalweg(run.maps, run.origin[:2], profile) if profile else {}
    from snowmpm.gis.lines import read_path
    from snowmpm.terrain.surface import TerrainSurface

    overwriting.reads(path)
    ground = TerrainSurface.sheet(run.terrain.vertices, run.terrain.facets)
    return along_path(run.maps, run.origin[:2], read_path(path, run),
                      lambda places: ground.height(places - run.origin[:2]) + run.origin[2])
