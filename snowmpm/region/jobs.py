"""What a worker does with a release: a window of the terrain, the flow on it, a larger window where the flow needs it.

The first window is where snow can get to by routing (`snowmpm.runout.routing`) at the travel angle `flow.reach`. If
snow leaves over a side that is not the border of the terrain, the window grows there, and the flow is run anew.
"""

import hashlib
import json
import math
import shutil
import time as clock
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import shapely

from snowmpm.campaigns import work
from snowmpm.draft import write_text
from snowmpm.errors import InputError, SimulationError
from snowmpm.region import friction, plan
from snowmpm.region.elevations import lattice, open_elevations, write_blocks
from snowmpm.region.forest import open_forest_once
from snowmpm.region.release_terrain import HALO

MAPPED = "peak_depth", "peak_speed", "peak_pressure"
LEFT = 1e-6
"""Share of the snow that may leave a window which could be larger."""
GROWTH = 0.5
"""Of the side of a window, by which it grows."""
MOST_TRIES = 8
COARSE = 15.0
"""Least side of the cells of the routing [m]."""
MARGIN = 150.0
"""Around what routing reaches [m]."""
FARTHEST = 8000.0
"""From a release, that routing looks at [m]."""
DEEP, HIGH = 9000.0, 1000.0
"""Below the lowest and above the highest place of a release [m], as far as its flow is followed."""
OUT_OF_REACH = "out of reach"
"""Reason of a release that was not run, since it cannot reach the area of interest."""


@dataclass(frozen=True)
class RegionJob:
    """A run of a release: of scenario, number of its area, sample; thickness and friction: factors on them; folder: of
    the region. Everything else lies there, so that a job is small."""

    hash: str
    folder: str
    scenario: str
    area: int
    sample: int
    thickness: float
    friction: float
    keep: str = "results"
    threads: int = 1
    plugins: tuple = ()
    backend: str = "cpu"
    mapped: tuple = MAPPED

    @property
    def results(self):
        """Folder of its numbers and maps."""
        return str(plan.results_of(self.folder, self.hash))

    @property
    def run(self):
        """Folder of the run itself."""
        return str(Path(self.folder) / "runs" / self.hash[:2] / self.hash)


class OutOfReach(InputError):
    """The release cannot reach the area of interest."""


def work_on(job):
    """Do a `RegionJob`, unless it is done; -> its record, with what the list of results needs."""
    about = {"hash": job.hash, "scenario": job.scenario, "area": job.area, "sample": job.sample}
    places = Path(job.results), Path(job.run), Path(job.run).with_name(f"{job.hash}_inputs")
    if any(place.is_symlink() or place.parent.is_symlink() for place in places):
        return {"status": "failed", "reason": "its folder is a link", "numbers": {}, "work": {}, **about}
    begun = clock.process_time()
    record = work.work_with(job, run_release)
    record.setdefault("work", {})["processor"] = clock.process_time() - begun
    if record["status"] == "failed" and record["reason"] == OUT_OF_REACH:
        return {**record, **about, "status": "out_of_reach"}
    return {**record, **about, "bounds": _bounds(job)}


def work_on_all(jobs):
    """Records of jobs, one after the other. Where one cannot be written, its record in place of all."""
    found = []
    for job in jobs:
        record = work_on(job)
        if record["status"] == work.UNWRITTEN:
            return record
        found.append(record)
    return found


def _bounds(job):
    """west, south, east, north [m] of its maps; None without."""
    file = Path(job.results) / work.MAPS
    if not file.is_file():
        return None
    with np.load(file) as maps:
        corner, cell, shape = maps["corner"], float(maps["cell"]), maps[MAPPED[0]].shape
    return [float(corner[0]), float(corner[1]), float(corner[0] + cell * shape[1]), float(corner[1] + cell * shape[0])]


def run_release(job):
    """(`Run`, whether it went on from a checkpoint) of the last window of a `RegionJob`. Raises OutOfReach, InputError,
    SimulationError."""
    work.start_quietly(job.backend, job.threads)
    setting = plan.read_setting(job.folder)
    area = plan.read_area(job.folder, job.scenario, job.area)
    inputs = Path(job.run).with_name(f"{job.hash}_inputs")
    try:
        with open_elevations(setting.terrain) as elevations:
            box = first_window(elevations, area, setting)
            for tries in range(MOST_TRIES):
                window = _window(elevations, box, setting)
                changes = changes_of(job, setting, area, elevations, window, inputs)
                run, resumed = work.run_job(work.Job(
                    job.hash, str(Path(job.folder) / plan.BASE), changes, job.results, job.run, job.keep, job.threads,
                    job.backend, job.plugins))
                grown = _grown(run, elevations.grid, box, setting.cell)
                if grown is None:
                    note_window(run, window, tries, elevations.grid)
                    return run, resumed
                box = grown
                shutil.rmtree(job.run)
    finally:
        if job.keep != "runs":  # the scene of a run that is kept names them
            shutil.rmtree(inputs, ignore_errors=True)
    raise SimulationError(f"the flow still leaves its window after {MOST_TRIES} of them: a smaller flow.reach begins"
                          " with a larger one")


def note_window(run, window, tries, grid):
    """Add to the numbers of a run its windows, and whether it touches the border of the terrain."""
    west, south, east, north = grid.bounds
    near = run.maps["peak_depth"].cell + grid.cell
    at = window[0] <= west + near, window[1] <= south + near, window[2] >= east - near, window[3] >= north - near
    run.hazard.setdefault("numbers", {})["windows"] = float(tries + 1)
    run.hazard["numbers"]["window_at_border"] = float(any(at))


def first_window(elevations, area, setting):
    """west, south, east, north [m] of where snow from an area can get to. Raises OutOfReach."""
    from snowmpm.runout.routing import Routing, route

    grid = elevations.grid
    step = max(1, math.ceil(COARSE / grid.cell - 1e-9))
    west, south, east, north = area.geometry.bounds
    around = FARTHEST
    # Nothing gets further than the highest place is above the lowest one around it, over tan(reach)
    for _ in range(3):
        rows, columns = grid.rows_of(south - around, north + around), grid.columns_of(west - around, east + around)
        rows, columns = (max(rows[0], 0), min(rows[1], grid.rows)), (max(columns[0], 0), min(columns[1], grid.columns))
        z = _coarse(elevations, rows, columns, step)
        low = float(np.nanmin(z)) if np.isfinite(z).any() else area.lowest
        needed = (area.highest - low) / math.tan(math.radians(setting.file.flow.reach)) + 4.0 * step * grid.cell
        if needed > 0.8 * around:
            break
        around = max(needed, 10.0 * step * grid.cell)
    cell = step * grid.cell
    ny, nx = z.shape
    x = grid.west + columns[0] * grid.cell + cell * (np.arange(nx) + 0.5)
    y = grid.north - rows[0] * grid.cell - cell * (np.arange(ny) + 0.5)
    inside = shapely.contains_xy(area.geometry, *np.meshgrid(x, y)) & np.isfinite(z)
    starts = np.argwhere(inside)
    if not len(starts):
        place = area.geometry.representative_point()
        starts = np.array([[int((grid.north - rows[0] * grid.cell - place.y) / cell),
                            int((place.x - grid.west - columns[0] * grid.cell) / cell)]]).clip(0, [ny - 1, nx - 1])
    # The rim of the area reaches as far as its middle does
    starts = starts[:: max(1, len(starts) // 60)]
    found = route(z, cell, starts, Routing(setting.file.flow.reach, 4.0))
    reached = np.isfinite(found.energy) | inside
    if setting.interest is not None and not _meets(reached, x, y, cell, setting.interest):
        raise OutOfReach(OUT_OF_REACH)
    i, j = np.nonzero(reached)
    return (min(x[j.min()] - MARGIN, west - MARGIN), min(y[i.max()] - MARGIN, south - MARGIN),
            max(x[j.max()] + MARGIN, east + MARGIN), max(y[i.min()] + MARGIN, north + MARGIN))


def _coarse(elevations, rows, columns, step):
    """Mean heights of step x step cells; NaN where one is missing."""
    rows = rows[0], rows[0] + (rows[1] - rows[0]) // step * step
    columns = columns[0], columns[0] + (columns[1] - columns[0]) // step * step
    z = elevations.read(rows, columns)
    return z.reshape(z.shape[0] // step, step, z.shape[1] // step, step).mean(axis=(1, 3))


def _meets(reached, x, y, cell, interest):
    """Whether one of the cells reached touches the area of interest."""
    from rasterio.features import geometry_mask
    from rasterio.transform import from_origin

    inside = geometry_mask([interest], reached.shape, from_origin(x[0] - 0.5 * cell, y[0] + 0.5 * cell, cell, cell),
                           all_touched=True, invert=True)
    return bool((reached & inside).any())


def _window(elevations, box, setting):
    """A box [m] on the lines of the maps, as far as the ground is known: between the middles of outermost cells."""
    grid = elevations.grid
    cells, half = lattice(grid, setting.cell), 0.5 * grid.cell
    found = []
    for low, high, begin, lowest, highest in (
            (box[0], box[2], cells.west, grid.bounds[0] + half, grid.bounds[2] - half),
            (box[1], box[3], cells.bounds[1], grid.bounds[1] + half, grid.bounds[3] - half)):
        first = max(math.floor((low - begin) / setting.cell), math.ceil((lowest - begin) / setting.cell - 1e-9))
        last = min(math.ceil((high - begin) / setting.cell), math.floor((highest - begin) / setting.cell + 1e-9))
        found.append((begin + setting.cell * first, begin + setting.cell * last))
    return found[0][0], found[1][0], found[0][1], found[1][1]


def _grown(run, grid, box, cell):
    """A larger box where snow left over a side that is not the border of the terrain, else None."""
    numbers = run.hazard.get("numbers", {})
    if numbers.get("left_share", 0.0) <= LEFT:
        return None
    raster = run.maps["peak_depth"]
    there = np.nan_to_num(raster.values) > 0.0
    west, south, east, north = grid.bounds
    wide, high = GROWTH * (box[2] - box[0]), GROWTH * (box[3] - box[1])
    near = cell + grid.cell
    touched = (there[:, :2].any() and box[0] > west + near, there[:2].any() and box[1] > south + near,
               there[:, -2:].any() and box[2] < east - near, there[-2:].any() and box[3] < north - near)
    if not any(touched):
        return None
    return tuple(side + sign * reach * bool(own) for side, sign, reach, own in zip(
        box, (-1.0, -1.0, 1.0, 1.0), (wide, high, wide, high), touched, strict=True))


def changes_of(job, setting, area, elevations, window, inputs):
    """Changes of the base scene for a window, whose files are written to the folder `inputs`."""
    area = _on_ground(area, window)
    thick = area.thickness * job.thickness
    volume = area.surface * thick
    inputs.mkdir(parents=True, exist_ok=True)
    release = write_text(inputs / "release.geojson", json.dumps(
        {"type": "FeatureCollection", "features": [
            {"type": "Feature", "properties": {}, "geometry": shapely.geometry.mapping(area.geometry)}],
         **({"crs": {"type": "name", "properties": {"name": setting.crs}}} if setting.crs else {})}))
    step = elevations.grid.cell
    changes = {
        # The cells of the flow are those of the maps; the ground is known a cell further
        "domain": {"min": [*window[:2], area.lowest - DEEP], "max": [*window[2:], area.highest + HIGH]},
        "terrain.region": {"x": [window[0] - step, window[2] + step], "y": [window[1] - step, window[3] + step]},
        "bodies.0.shape.region": {"file": str(release)}, "bodies.0.shape.top": float(f"{thick:.9g}")}
    if setting.file.friction.classes:
        changes["terrain.friction"] = _classes(job, setting, elevations, window, inputs, volume)
    else:
        changes["terrain.friction"] = friction.of_card(setting.file.friction.card, volume, job.friction)
    if setting.file.forest and setting.file.forest.drag:
        rows, columns = _cells(elevations.grid, window)
        with open_forest_once(setting.forest, elevations.grid, setting.file.forest.cover) as forest:
            trees = forest.mask(elevations.grid, rows, columns)
        if trees.any():
            drag = np.where(trees, setting.file.forest.drag, np.nan)
            write_blocks(inputs / "drag.tif", _part(elevations.grid, rows, columns),
                         [((0, trees.shape[0]), (0, trees.shape[1]), drag)])
            changes["terrain.forest"] = [{"name": "forest", "drag": {"file": str(inputs / "drag.tif")}}]
    return changes


def _on_ground(area, window):
    """The area, less what lies beyond a window: at the border of the terrain by half a cell."""
    inside = area.geometry.intersection(shapely.box(*window))
    if inside.area >= (1.0 - 1e-9) * area.geometry.area:
        return area
    parts = [part for part in shapely.get_parts(inside) if part.geom_type == "Polygon"]
    if not parts or inside.area < 0.5 * area.geometry.area:
        raise SimulationError("it lies off the terrain")
    return replace(area, geometry=shapely.MultiPolygon(parts),
                   surface=area.surface * inside.area / area.geometry.area)


def _cells(grid, window):
    """Rows and columns, first and last + 1, of a window [m], with a cell around it."""
    rows, columns = grid.rows_of(window[1], window[3]), grid.columns_of(window[0], window[2])
    return ((max(rows[0] - 1, 0), min(rows[1] + 1, grid.rows)),
            (max(columns[0] - 1, 0), min(columns[1] + 1, grid.columns)))


def _part(grid, rows, columns):
    """`Grid` of a window."""
    return replace(grid, west=grid.west + columns[0] * grid.cell, north=grid.north - rows[0] * grid.cell,
                   rows=rows[1] - rows[0], columns=columns[1] - columns[0])


def _classes(job, setting, elevations, window, inputs, volume):
    """Table of Voellmy friction with rasters of mu and xi over a window."""
    rows, columns = _cells(elevations.grid, window)
    z = elevations.read((rows[0] - HALO, rows[1] + HALO), (columns[0] - HALO, columns[1] + HALO))
    inner = np.s_[HALO:-HALO, HALO:-HALO]
    shares = friction.kinds(z, elevations.grid.cell)[(slice(None), *inner)]
    mu, xi = friction.numbers(setting.file.friction.classes, volume, z[inner], shares)
    part, found = _part(elevations.grid, rows, columns), {"law": "voellmy"}
    for name, values in (("mu", job.friction * mu), ("xi", xi)):
        write_blocks(inputs / f"{name}.tif", part, [((0, part.rows), (0, part.columns), values)])
        found[name] = {"file": str(inputs / f"{name}.tif")}
    return found


def hash_of(*parts):
    """Name of a run."""
    return hashlib.sha256(json.dumps(parts, sort_keys=True).encode()).hexdigest()[:16]
