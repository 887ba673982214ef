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
from scipy.ndimage import map_coordinates
from scipy.spatial import cKDTree

WIDTH = 600.0
"""Width of the cross-sections [m]."""
PRESSURE = 1e3
"""Peak pressure [Pa] above which a place is reached."""
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


def along_path(maps, origin, line, height):
    """Numbers by name, as `snowmpm.quantities.table.PATH` defines them.

    maps: `snowmpm.io.Map` by name; origin (2,) of their coordinates [m]; line (n, 2): the path in map coordinates, in
    either direction; height: function of places (k, 2) -> height of the ground (k,) [m], NaN where it is unknown.
    Those of a run-out are missing where nothing is above `PRESSURE`.
    """
    line = line[np.concatenate([[True], np.linalg.norm(np.diff(line, axis=0), axis=1) > 0.0])]
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
        return numbers
    first, last = int(reached[0]), int(reached[-1])
    high, low = height(found.middles[[first, last]])
    delta = float(found.s[last] - found.s[first])
    place = found.places[last, int(values["path_pressure"][last].argmax())]
    numbers |= {"path_runout": float(found.s[last]), "path_runout_x": float(place[0]),
                "path_runout_y": float(place[1]), "path_delta": delta}
    if np.isfinite(high - low):
        numbers |= {"path_fall": float(high - low), "path_angle": float(np.degrees(np.arctan2(high - low, delta)))}
    return numbers


def along_thalweg(maps, origin, profile):
    """`along_path` of the thalweg of a run; profile: its x, y, z (`snowmpm.results.hazard.Hazard.profile`)."""
    line, z = np.column_stack([profile["x"], profile["y"]]), np.asarray(profile["z"], float)
    return along_path(maps, origin, line, lambda places: z[cKDTree(line).query(places)[1]])


def _read(raster, origin, places):
    at = (places.reshape(-1, 2) - origin - [raster.x0, raster.y0]) / raster.cell
    values = np.nan_to_num(raster.values).astype(float)
    return map_coordinates(values, at.T[::-1], order=1, mode="constant").reshape(places.shape[:2])


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
