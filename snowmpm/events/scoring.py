"""How near a run is to what was observed, by the definitions of `snowmpm.quantities.scores`.

Areas are compared as AIMEC does (true and false positives, false negatives), but over plan areas, and not over
cross-sections of a path, which overlap in bends.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import shapely

from snowmpm.errors import InputError
from snowmpm.events.checks import checked_areas
from snowmpm.events.spec import Event
from snowmpm.events.store import event
from snowmpm.gis.observed import compare, reach_along, system_of
from snowmpm.gis.outlines import outline

BEYOND = 1.0
"""Distance from the end of a path [m] within which a flow counts as going beyond it."""


@dataclass(frozen=True)
class Observation:
    """What was observed, in map coordinates. outline, deposit: polygons, or None."""

    event: Event
    outline: Any
    deposit: Any

    @classmethod
    def of(cls, name, system=None):
        """Of an event, in the system of its terrain, or in another `ReferenceSystem`. InputError."""
        own, *areas = checked_areas(name)
        if system is not None and own is not None:
            areas = [area if area is None else shapely.transform(area, lambda corners: own.carried(corners, system))
                     for area in areas]
        return cls(event(name), *areas)

    @property
    def rings(self):
        """Outlines that were observed, (n, 2) each [m]."""
        parts = [part for area in (self.outline, self.deposit) if area is not None for part in shapely.get_parts(area)]
        return [np.array(part.exterior.coords)[:-1, :2] for part in parts]


    @property
    def places(self):
        """(words, corners (n, 2)) of the path, of where the flow stopped, and of measured values."""
        seen, found = self.event.observed, []
        if seen.path:
            found.append(("path", np.array(seen.path)))
        if seen.stopped:
            found.append(("stopped here", np.array([[seen.stopped.x, seen.stopped.y]])))
        return found + [("measured here", np.array([[one.x, one.y]])) for one in seen.values if one.x is not None]


@dataclass(frozen=True)
class Computed:
    """What a run computed. maps: `snowmpm.io.Map` by name; origin (2,) of their coordinates [m]; numbers: of hazard
    mapping; height: function of places (k, 2) in map coordinates -> height of the ground (k,) [m], None where it is
    not known."""

    maps: dict[str, Any]
    origin: Any
    numbers: dict[str, Any]
    height: Callable[[Any], Any] | None = None

    @classmethod
    def of(cls, run):
        """Of a `Run`. InputError for one without maps."""
        numbers = run.hazard.get("numbers", {})
        if "peak_depth" not in run.maps or "flow_depth" not in numbers:
            raise InputError(f"{run.path}: has no maps to compare with what was observed")

        def height(places):
            return run.terrain.heights(places - run.origin[:2]) + run.origin[2]

        return cls(run.maps, run.origin[:2], numbers, height if run.terrain is not None else None)

    def area(self, name):
        """Polygons of the cells that have at least flow_depth on a map, or None."""
        cells = np.nan_to_num(self.maps[name].values) >= self.numbers["flow_depth"]
        return outline(cells, self.maps[name], self.origin) if cells.any() else None


def score_run(run, name):
    """`scores` of a `Run` against an event, and its `Observation`."""
    observation = Observation.of(name, system_of(run))
    return scores(Computed.of(run), observation), observation


def scores(run, observation):
    """{name: number} of what was `Computed`, by the names of `snowmpm.quantities.scores`; what was not observed is
    missing, and what the run does not have is None. value_error_0, ...: of each measured value; runout_beyond: whether
    the flow reaches the end of the path, so that its run-out is at least that."""
    seen, computed = observation.event.observed, run.area("peak_depth")
    found, misfits = {}, []
    if seen.outline:
        found |= _of_area(computed, observation.outline)
        misfits.append((1.0 - found["success_index"]) / _unsure(observation.outline, seen.outline.uncertainty))
    if seen.path and (seen.stopped or seen.outline):
        found |= _of_runout(run, computed, observation)
        error, known = found["runout_error"], (seen.stopped or seen.outline).uncertainty
        misfits.append(np.inf if error is None else error / known)
    if seen.deposit:
        index = _of_area(run.area("deposit_depth"), observation.deposit)["success_index"]
        found["deposit_success_index"] = index
        misfits.append((1.0 - index) / _unsure(observation.deposit, seen.deposit.uncertainty))
    if seen.deposit_volume:
        volume = run.numbers.get("deposit_volume", 0.0)
        found["deposit_ratio"] = volume / seen.deposit_volume.value
        misfits.append((volume - seen.deposit_volume.value) / seen.deposit_volume.deviation)
    for k, one in enumerate(seen.values):
        error = _value(run, one)
        found[f"value_error_{k}"] = error if error is None or not one.at_least else min(error, 0.0)
        if not one.at_least or error is None or error < 0.0:  # what is more than a least value says nothing
            misfits.append(np.inf if error is None else error)
    return {"misfit": float(np.sqrt(np.mean(np.square(misfits)))) if misfits else 0.0, **found}


def _of_area(computed, observed):
    if computed is None:
        return {"success_index": 0.0, "hit_rate": 0.0, "false_alarm_ratio": None, "area_ratio": 0.0}
    found = compare(computed, observed)
    return {"success_index": found["critical_success_index"],
            **{name: found[name] for name in ("hit_rate", "false_alarm_ratio", "area_ratio")}}


def _unsure(area, distance):
    """1 - critical success index of an area against itself with its border moved by a distance, mean of out and in."""
    whole = shapely.area(area)
    wider, narrower = (shapely.area(shapely.buffer(area, d)) for d in (distance, -distance))
    return float(0.5 * ((1.0 - whole / wider) + (1.0 - narrower / whole)))


def observed_reach(observation):
    """Length [m] along the path of the event to where the flow stopped; None where that was not observed."""
    seen = observation.event.observed
    if not seen.path or not (seen.stopped or seen.outline):
        return None
    line = shapely.LineString(seen.path)
    if seen.stopped:
        return float(shapely.line_locate_point(line, shapely.Point(seen.stopped.x, seen.stopped.y)))
    return reach_along(line, observation.outline)


def _of_runout(run, computed, observation):
    """Run-out along the path of the event, less that which was observed."""
    line, far = shapely.LineString(observation.event.observed.path), observed_reach(observation)
    if computed is None:
        return {"runout_error": None, "angle_error": None, "runout_beyond": False}
    own = reach_along(line, computed)
    found = {"runout_error": own - far, "angle_error": None, "runout_beyond": own > line.length - BEYOND}
    if run.height is not None and min(own, far) > 0.0:
        places = np.array([shapely.line_interpolate_point(line, s).coords[0] for s in (0.0, own, far)])
        top, here, there = (float(z) for z in run.height(places))
        angles = [np.degrees(np.arctan2(top - z, s)) for z, s in ((here, own), (there, far))]
        found["angle_error"] = float(angles[0] - angles[1])
    return found


def _value(run, one):
    """A map at a place, or its largest value, less what was measured, over the deviation; without flow there, and
    beside the map, 0 was computed. None where the run has no such map."""
    raster = run.maps.get(one.map)
    if raster is None:
        return None
    if one.x is None:
        return float((np.nan_to_num(raster.values).max() - one.value) / one.deviation)
    rows, columns = raster.values.shape
    east = np.abs(run.origin[0] + raster.x0 + raster.cell * np.arange(columns) - one.x)
    north = np.abs(run.origin[1] + raster.y0 + raster.cell * np.arange(rows) - one.y)
    if min(east.min(), north.min()) > 0.5 * raster.cell:
        return 0.0 - one.value / one.deviation
    near = np.hypot(east[None, :], north[:, None]) <= one.within
    near[north.argmin(), east.argmin()] = True
    return float((np.nan_to_num(raster.values)[near].max() - one.value) / one.deviation)
