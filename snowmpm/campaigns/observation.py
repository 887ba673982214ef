"""How far a run is from what was observed.

    distance = sqrt(mean of ((computed - observed) / deviation)^2)

over the run-out, the deposit's volume, each front time, and for an outline 1 - (critical success index), which is 0
where computed and observed area are the same (`snowmpm.gis.observed`). Of an event it is the misfit of
`snowmpm.events.scoring`. A run without such a number is infinitely far.
The front time of a place that the flow does not reach is the end of the run.
"""

import math
from pathlib import Path

import numpy as np

from snowmpm.campaigns import untrusted
from snowmpm.campaigns.work import MAPPED, MAPS
from snowmpm.errors import InputError


class Observation:
    """What was observed, read once. file: `CampaignFile` with a calibration."""

    def __init__(self, file):
        self._wanted, self._file = file.calibration.observed, file
        self._numbers = {name: one for name in ("runout", "deposit_volume") if (one := self._wanted[name])}
        self._outline = self._event = None
        if self._wanted.event:
            from snowmpm.events.scoring import Observation as Event
            from snowmpm.events.store import scene_file

            scene_file(self._wanted.event)  # its files are fetched now, not by the first run
            self._event = Event.of(self._wanted.event)
            for k, one in enumerate(self._event.event.observed.values):
                if one.map not in MAPPED:
                    raise InputError.at(f"event:{self._wanted.event}: observed.values.{k}.map", one.map,
                                        f"campaigns keep {', '.join(MAPPED)}")
        if self._wanted.outline:
            self._outline = _polygon(Path(file.base_dir, self._wanted.outline.file), file.source)

    @property
    def rings(self):
        """Outlines that were observed, (n, 2) each [m]."""
        import shapely

        parts = shapely.get_parts(self._outline) if self._outline is not None else []
        return [np.array(part.exterior.coords)[:-1, :2] for part in parts]

    def misfits(self, record, results):
        """{name: misfit over its deviation} of a run. record: its record; results: its folder."""
        numbers = record.get("numbers", {})
        if self._event is not None:
            return {"event": self._misfit(numbers, results)}
        found = {name: (numbers.get(name, math.inf) - one.value) / one.deviation for name, one in self._numbers.items()}
        if self._outline is None and not self._wanted.front_times:
            return found
        maps = untrusted.maps(Path(results) / MAPS, ("peak_depth", "arrival_time"))
        corner, cell = maps["corner"], float(maps["cell"])
        if self._outline is not None:
            affected = np.nan_to_num(maps["peak_depth"]) >= numbers.get("flow_depth", 0.0)
            index = success(affected, corner, cell, self._outline)
            found["outline"] = (1.0 - index) / self._wanted.outline.deviation
        for k, one in enumerate(self._wanted.front_times):
            time = _at(maps["arrival_time"], corner, cell, one.x, one.y, numbers["end"])
            found[f"front_time_{k}"] = (time - one.time) / one.deviation
        return found

    def _misfit(self, numbers, results):
        from snowmpm.events.scoring import Computed, scores
        from snowmpm.io.ground_maps import Map

        if "flow_depth" not in numbers:
            return math.inf
        maps = untrusted.maps(Path(results) / MAPS, MAPPED)
        cell, corner = float(maps["cell"]), maps["corner"]
        rasters = {name: Map(maps[name], 0.5 * cell, 0.5 * cell, cell, "") for name in MAPPED}
        return scores(Computed(rasters, corner, numbers), self._event)["misfit"]

    def distance(self, record, results):
        """Distance of a run; infinite of one that failed."""
        if record.get("status") != "done":
            return math.inf
        found = np.array(list(self.misfits(record, results).values()))
        return float(np.sqrt(np.mean(found**2)))


def success(affected, corner, cell, polygon):
    """Critical success index of the cells that are affected (rows, columns) against a polygon, by exact areas."""
    import shapely

    rows, columns = np.nonzero(affected)
    west, south = corner[0] + cell * columns, corner[1] + cell * rows
    boxes = shapely.box(west, south, west + cell, south + cell)
    shapely.prepare(polygon)
    hit = float(shapely.area(shapely.intersection(boxes, polygon)).sum())
    computed, observed = len(boxes) * cell**2, float(shapely.area(polygon))
    return hit / max(computed + observed - hit, 1e-300)


def _at(raster, corner, cell, x, y, otherwise):
    """Value of a raster at a place; `otherwise` outside and where it has none."""
    column, row = (math.floor((place - start) / cell) for place, start in zip((x, y), corner, strict=True))
    if 0 <= row < raster.shape[0] and 0 <= column < raster.shape[1] and np.isfinite(raster[row, column]):
        return float(raster[row, column])
    return otherwise


def _polygon(path, source):
    import shapely

    from snowmpm.seeding.regions import read_regions

    if not path.is_file():
        raise InputError(f"{source}: calibration.observed.outline.file = \"{path}\": no such file")
    regions = read_regions(path, "calibration.observed.outline.file", None)
    return shapely.union_all([region.polygons.geometry for region in regions])
