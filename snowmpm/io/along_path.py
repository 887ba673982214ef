"""Numbers of a run along a path, as AvaFrame's AIMEC defines them (Fischer 2013, doi:10.5194/nhess-13-1655-2013).

Cross-sections stand on the path, as wide as `WIDTH`, normal to the bisector of its pieces at its corners and turned
evenly between them; places along them are as far apart as map cells. On them the peak maps are read, linear between the
middles of their cells, 0 without snow. s [m] is the length along the path in plan, from its upper end.

    run-out     s of the last cross-section whose largest peak pressure is above `PRESSURE`
    delta       from the first such cross-section to it; its angle by the heights of the path there
    maxima      the largest value of each map over all cross-sections

The area is not summed over cross-sections, which overlap in bends, but over map cells beside the path, no further from
it than half of `WIDTH`, each by the area of its ground, which is larger than in plan by 1 / cos of its slope.
"""

import itertools
from dataclasses import dataclass

import numpy as np
import shapely

from snowmpm.errors import InputError
from snowmpm.quantities.thalweg import ahead_of

WIDTH = 600.0
"""Width of the cross-sections [m]."""
PRESSURE = 1e3
"""Peak pressure [Pa] above which a place is reached."""
FURTHER = 0.3
"""Share of its length by which the thalweg is extended straight, as AIMEC extends a path: it ends at the run-out."""
MOST = 5_000_000
"""Places on all cross-sections."""
MAXIMA = {"path_pressure": "peak_pressure", "path_thickness": "peak_thickness", "path_speed": "peak_speed"}
"""Number: map whose largest value on the cross-sections it is."""


@dataclass(frozen=True)
class Sections:
    """Cross-sections: places (n, k, 2) in map coordinates, and s (n,) [m] of their middles."""

    places: np.ndarray
    s: np.ndarray

    @property
    def middles(self):
        """(n, 2)"""
        return self.places[:, self.places.shape[1] // 2]


def sections(line, cell, width=WIDTH):
    """`Sections` of a path (n, 2) [m], whose corners are apart."""
    pieces = np.diff(line, axis=0)
    directions = pieces / np.linalg.norm(pieces, axis=1)[:, None]
    bisectors = np.concatenate([directions[:1], directions[1:] + directions[:-1], directions[-1:]])
    bisectors /= np.maximum(np.linalg.norm(bisectors, axis=1), 1e-12)[:, None]
    across = 0.5 * width * np.column_stack([-bisectors[:, 1], bisectors[:, 0]])
    ends = np.stack([line + across, line - across], axis=1)
    rows = []
    for first, second in itertools.pairwise(ends):
        count = int(np.ceil(np.linalg.norm(second - first, axis=1).max() / cell)) + 1
        rows.append(first + np.linspace(0.0, 1.0, count)[:, None, None] * (second - first))
    left, right = np.moveaxis(np.concatenate([*(row[:-1] for row in rows), rows[-1][-1:]]), 1, 0)
    wide = 2 * int(np.ceil(0.5 * width / cell)) + 1
    places = left[:, None] + np.linspace(0.0, 1.0, wide)[:, None] * (right - left)[:, None]
    middles = 0.5 * (left + right)
    return Sections(places, np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(middles, axis=0), axis=1))]))


def along_path(maps, origin, line, height, where="--path"):
    """Numbers by name, as `snowmpm.quantities.table.PATH` defines them, and whether the flow is still above `PRESSURE`
    on the last cross-section: then the run-out is the length of the path.

    maps: `snowmpm.io.Map` by name; origin (2,) of their coordinates [m]; line (n, 2): the path in map coordinates, in
    either direction; height: function of places (k, 2) -> height of the ground (k,) [m], NaN where it is unknown;
    where: the path comes from, for messages. Those of a run-out are missing where nothing is above `PRESSURE`. Raises
    InputError for a path beside the maps, and for one that is too long.
    """
    line = line[np.concatenate([[True], np.linalg.norm(np.diff(line, axis=0), axis=1) > 0.0])]
    _require_place(maps["peak_pressure"], origin, line, where)
    ends = height(line[[0, -1]])
    if ends[1] > ends[0]:
        line = line[::-1]
    pressure = maps["peak_pressure"]
    found = sections(line, pressure.cell)
    values = {name: _read(maps[raster], origin, found.places) for name, raster in MAXIMA.items() if raster in maps}
    numbers = {name: float(one.max()) for name, one in values.items()}
    reached = np.flatnonzero(values["path_pressure"].max(axis=1) > PRESSURE)
    numbers["path_area"] = _area(maps, origin, line)
    if not len(reached):
        return numbers, False
    first, last = int(reached[0]), int(reached[-1])
    high, low = height(found.middles[[first, last]])
    delta = float(found.s[last] - found.s[first])
    place = found.places[last, int(values["path_pressure"][last].argmax())]
    numbers |= {"path_runout": float(found.s[last]), "path_runout_x": float(place[0]),
                "path_runout_y": float(place[1]), "path_delta": delta}
    if np.isfinite(high - low):
        numbers |= {"path_fall": float(high - low), "path_angle": float(np.degrees(np.arctan2(high - low, delta)))}
    return numbers, last == len(found.s) - 1


def extended(profile):
    """The thalweg of a run (n, 2), extended straight by `FURTHER`; profile: its x, y, s
    (`snowmpm.results.hazard.Hazard.profile`)."""
    line = np.column_stack([profile["x"], profile["y"]])
    return np.concatenate([line, line[-1:] + FURTHER * profile["s"][-1] * ahead_of(line)])


def _require_place(raster, origin, line, where):
    """Raises InputError for a path beside a map, or with more than MOST places on its cross-sections."""
    rows, columns = raster.values.shape
    low = origin + np.array([raster.x0, raster.y0]) - 0.5 * raster.cell
    box = shapely.box(*low, *(low + raster.cell * np.array([columns, rows])))
    if not shapely.intersects(box, shapely.LineString(line)):
        raise InputError(f"{where}: lies beside the maps: is its coordinate system right?")
    # Twice as long where cross-sections turn
    count = 2.0 * float(np.linalg.norm(np.diff(line, axis=0), axis=1).sum()) / raster.cell + len(line)
    if not count * WIDTH / raster.cell <= MOST:
        raise InputError(f"{where}: {count:.3g} cross-sections of {WIDTH:g} m on cells of {raster.cell:g} m are too"
                         " many: take a shorter path, with fewer corners")


def _read(raster, origin, places):
    return raster.between(places.reshape(-1, 2) - origin).reshape(places.shape[:2])


def _area(maps, origin, line):
    """Area [m2] of the ground under the cells near the path whose peak pressure is above `PRESSURE`."""
    raster = maps["peak_pressure"]
    row, column = np.nonzero(np.nan_to_num(raster.values) > PRESSURE)
    places = origin + np.column_stack([raster.x0 + raster.cell * column, raster.y0 + raster.cell * row])
    path, points = shapely.LineString(line), shapely.points(places)
    s = shapely.line_locate_point(path, points)
    near = (shapely.distance(path, points) <= 0.5 * WIDTH) & (s > 0.0) & (s < path.length)
    cosine = np.ones(len(row))
    if "peak_thickness" in maps:
        cosine = maps["peak_thickness"].values[row, column] / maps["peak_depth"].values[row, column]
    return raster.cell**2 * float((1.0 / cosine[near]).sum())
