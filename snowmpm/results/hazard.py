"""Numbers of hazard mapping from the maps of a run (defined in `snowmpm.quantities.table`).

Thalweg: the path of the flow in plan. It connects the centres of momentum, x = sum m |v| x / sum m |v|, of the frames
with a total momentum above `LEAST_MOMENTUM` of its maximum, as long as they go on: down, or straight ahead. It begins
at the top of the release and is extended straight at its end. s [m] is its length in plan; every map cell belongs to
the s of the nearest point of the thalweg.

Run-out: the s before which `RUNOUT_SHARE` of the snow lies at the end, so that no single particle sets it. Travel angle
(Fahrboeschung) alpha = atan(fall / s), fall from the top of the release to the ground of the thalweg there.

Affected area: where the flow depth once was at least a tenth of the mean release depth. area_above_1_kPa, where the
pressure also reached 1 kPa, is the affected area of AvaFrame's AIMEC with its default threshold. The reach of an area
is the largest s of the corners of its cells.

Areas are sums of map cells, except that of the release, whose outline is known: cells that it only touches count in
part. Cells are classified by the maps as stored, in float32, so that readers of the file find the same.
"""

from dataclasses import dataclass, field, replace

import numpy as np
import shapely
from scipy.ndimage import gaussian_filter1d
from scipy.spatial import cKDTree

from snowmpm.quantities.classes import PRESSURES, classes_of

RUNOUT_SHARE = 0.99
"""Share of the snow before the run-out line."""

LEAST_MOMENTUM = 0.05
"""Total momentum over its maximum below which the centre of momentum does not count for the thalweg."""

TOP_SHARE = 0.05
"""Share of the height of the release that counts as its top."""

TOP_POINTS = 4.0
"""Points per side of a map cell at which the terrain under the release is searched for its top."""

MOST_TOP_POINTS = 300
"""Approximate largest number of such points along a side of the release."""

CORNERS = np.array([[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]])

AHEAD = np.cos(np.radians(30.0))
"""Cosine of the largest turn of a path that climbs, from the direction in which it came down."""

STRAIGHT = 3.0
"""Least length [map cells] over which the direction of the path is taken."""

SMOOTHING = 4.0
"""Standard deviation [map cells] of the smoothing of the thalweg."""


@dataclass(frozen=True)
class Thalweg:
    """A line in plan: equidistant points (n, 2) [m], and s (n,) [m] along it."""

    points: np.ndarray
    s: np.ndarray

    def along(self, places):
        """s of the nearest point (k,) of plan places (k, 2)."""
        return self.s[cKDTree(self.points).query(places)[1]]

    def reach(self, places, cell):
        """Largest length [m] along the line to which cells of this side with middles (k, 2) reach; 0 of none."""
        if not len(places):
            return 0.0
        # Only the furthest cells, by their nearest point: to find where a corner lies costs as much as the line is long
        s = self.along(places)
        spacing = float(np.diff(self.s).max())
        furthest = places[s >= s.max() - 2.0 * (cell + spacing)]
        corners = (furthest[:, None] + cell * CORNERS).reshape(-1, 2)
        line = shapely.LineString(self.points)
        return float(shapely.line_locate_point(line, shapely.points(np.unique(corners, axis=0))).max(initial=0.0))


def thalweg(top, path, momentum, step, reach, ground):
    """The thalweg from `top` (2,) through `path` (k, 2), each with its momentum (k,), a point every `step` [m]; ground:
    function of plan positions (k, 2) -> height (k,) [m].

    Points that do not go on are left out. The line is extended straight in its last direction by `reach` [m]. None if
    nothing moved further than a few steps.
    """
    carried = momentum > LEAST_MOMENTUM * momentum.max(initial=0.0)
    line, path = [np.asarray(top, float)], path[carried]
    lowest, down = np.inf, 1  # height of the lowest point so far, and how many points lead to it
    for place, height in zip(path, ground(path), strict=True):
        onward, climbs = place - line[-1], height > lowest
        # What climbs is to keep the direction in which it came down
        direction = _direction(line[:down] if climbs else line, step)
        if np.linalg.norm(onward) > step and _cosine(onward, direction) >= (AHEAD if climbs else 0.0):
            line.append(place)
            if not climbs:
                lowest, down = height, len(line)
    if len(line) < 3:
        return None
    line = equally_spaced(smoothed(equally_spaced(np.array(line), step)), step)
    ahead = line[-1] - line[max(0, len(line) - 1 - int(3 * SMOOTHING))]
    ahead /= np.linalg.norm(ahead)
    line = np.concatenate([line, line[-1] + step * np.arange(1, int(reach / step) + 1)[:, None] * ahead])
    return Thalweg(line, np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))]))


def _direction(line, step):
    """From the last point of a line that is `STRAIGHT` steps before its end or more to its end (2,) [m]; 0 of a point.

    When the front rests and the rear still moves, the centre of momentum moves back up. It does so in an arc if
    branches of the flow come to rest one after the other.
    """
    for before in line[-2::-1]:
        if np.linalg.norm(line[-1] - before) >= STRAIGHT * step:
            return line[-1] - before
    return line[-1] - line[0]


def _cosine(onward, direction):
    """Cosine of the angle between two ways (2,); 1 for one of no length."""
    lengths = float(np.linalg.norm(onward) * np.linalg.norm(direction))
    return onward @ direction / lengths if lengths > 0.0 else 1.0


def equally_spaced(line, step):
    """Points every `step` [m] along a line (n, 2)."""
    s = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
    at = np.arange(0.0, s[-1] + step, step).clip(max=s[-1])
    return np.column_stack([np.interp(at, s, line[:, axis]) for axis in (0, 1)])


def smoothed(line):
    """The line (n, 2) smoothed over a few points; its ends stay."""
    straight = line[0] + np.linspace(0.0, 1.0, len(line))[:, None] * (line[-1] - line[0])
    # The deviation from a straight line is zero at both ends; antisymmetric mirroring keeps it so
    bend = line - straight
    mirrored = np.concatenate([-bend[:0:-1], bend, -bend[-2::-1]])
    smooth = gaussian_filter1d(mirrored, SMOOTHING, axis=0)[len(line) - 1 : 2 * len(line) - 1]
    return straight + smooth


@dataclass(frozen=True)
class Hazard:
    """numbers: by name, as `snowmpm.quantities.table.NUMBERS` defines them; classes: areas by class (`areas_by_class`),
    by the name of the map; profile: arrays along the thalweg by name (x, y, z, s,
    peak_depth, peak_speed, peak_pressure, deposit_depth: largest value across it); line: the two ends of the run-out
    line (2, 2) [m], or None; release: the outline of the release (shapely, in map coordinates).
    """

    numbers: dict
    profile: dict
    line: np.ndarray | None
    classes: dict = field(default_factory=dict)
    release: object = None

    def record(self):
        """As plain lists and numbers, for a file."""
        profile = {name: [round(float(v), 3) for v in values] for name, values in self.profile.items()}
        return {"numbers": self.numbers, "classes": self.classes, "profile": profile, "release": rings(self.release),
                "runout_line": None if self.line is None else np.round(self.line, 3).tolist()}


def rings(area):
    """[[ring, hole, ...], ...] of the polygons of a shapely geometry, each a list of [x, y]."""
    return [[[list(corner) for corner in ring.coords] for ring in (part.exterior, *part.interiors)]
            for part in shapely.get_parts(area)]


def assess(maps, lower, cell, flow_depth, path, momentum, whole, ground, release):
    """Numbers of hazard mapping of a run -> `Hazard`.

    maps: by name, (columns along x, rows along y), zero without snow
    (`snowmpm.results.maps.PeakMaps.values`); lower (2,), cell [m]: their corner and the side of a cell; flow_depth [m]:
    thinner is not affected; path (k, 2), momentum (k,): centre and size of the momentum; whole:
    numbers of all the snow, copied as they are (release_mass,
    deposit_mass, moving_share, momentum_share, left_share);
    ground: function of plan positions (k, 2) -> height (k,) [m]; release: plan area of the snow at the start (shapely).
    """
    maps = {name: values.astype(np.float32) for name, values in maps.items()}
    peak, deposit, depth = maps["peak_depth"], maps["deposit_depth"], maps["release_depth"]
    area = cell**2
    affected, deposited = peak >= flow_depth, deposit >= flow_depth
    numbers = {"release_area": float(release.area), "release_volume": area * float(depth.sum(dtype=float)),
               "affected_area": area * int(affected.sum())}
    for pressure in PRESSURES:
        above = (maps["peak_pressure"] >= pressure) & affected
        numbers[f"area_above_{pressure / 1e3:g}_kPa"] = area * int(above.sum())
    for name, map_name in (("depth", "peak_depth"), ("speed", "peak_speed"), ("pressure", "peak_pressure")):
        numbers[f"largest_flow_{name}"] = float(maps[map_name].max())
    numbers["deposit_area"] = area * int(deposited.sum())
    numbers["deposit_volume"] = area * float(deposit.sum(dtype=float))
    numbers["deposit_mean_depth"] = float(deposit[deposited].mean(dtype=float)) if deposited.any() else 0.0
    numbers = {**numbers, "flow_depth": flow_depth, **whole}
    counted = {"peak_pressure": affected, "peak_depth": affected, "peak_speed": affected, "deposit_depth": deposited}
    classes = {name: areas_by_class(maps[name][where], classes_of(name, float(maps[name].max())), area)
               for name, where in counted.items()}
    places = lower + cell * (np.argwhere(peak > 0.0) + 0.5)
    if release.is_empty:
        return Hazard(numbers, {}, None, classes, release)
    found = top_of(release, cell, ground)
    if found is None:
        return Hazard(numbers, {}, None, classes, release)
    high, top = found
    way = thalweg(top, path, momentum, cell, float(np.linalg.norm(np.ptp(places, axis=0))), ground)
    if way is None:
        return Hazard(numbers, {}, None, classes, release)
    found = _along(way, maps, places, cell, affected, numbers, high, ground)
    return replace(found, classes=classes, release=release)


def top_of(release, cell, ground):
    """Height [m] of the highest ground under the release, and the middle (2,) [m] of the highest part of it, whose
    height is within `TOP_SHARE` of that: the highest point itself may be a corner. None over holes alone."""
    lower, upper = np.array(release.bounds).reshape(2, 2)
    fine = min(cell / TOP_POINTS, 0.05 * float(np.sqrt(release.area)))
    step = max(fine, float((upper - lower).max()) / MOST_TOP_POINTS)
    axes = [np.arange(a + 0.5 * step, b, step) for a, b in zip(lower, upper, strict=True)]
    inner = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 2)
    inner = inner[shapely.contains_xy(release, *inner.T)]
    points = np.concatenate([inner, shapely.get_coordinates(shapely.segmentize(release.boundary, step))])
    heights = ground(points)
    points, heights = points[np.isfinite(heights)], heights[np.isfinite(heights)]
    if not len(heights):
        return None
    high, low = float(heights.max()), float(heights.min())
    return high, points[heights >= high - TOP_SHARE * (high - low)].mean(axis=0)


def areas_by_class(values, classes, area):
    """[{"class": words, "from", "to": limits, None: open; "area" [m2]}] of values (n,), one a map cell."""
    ends = np.concatenate([[0.0], classes.limits, [np.inf]])
    counts = np.bincount(np.digitize(values, classes.limits), minlength=len(classes.limits) + 1)
    upper = [*classes.limits, None]
    return [{"class": classes.label(k), "from": float(ends[k]), "to": upper[k], "area": area * int(n)}
            for k, n in enumerate(counts)]


def _along(way, maps, places, cell, affected, numbers, top, ground):
    """The run-out and the profile along the thalweg, added to the numbers."""
    touched = maps["peak_depth"] > 0.0
    s = way.along(places)
    runout = _quantile(s, maps["deposit_depth"][touched], RUNOUT_SHARE, cell)
    z = ground(way.points)
    end = int(np.searchsorted(way.s, runout).clip(max=len(way.s) - 1))
    # Between the points of the thalweg, which are a map cell apart
    place = np.array([np.interp(runout, way.s, way.points[:, axis]) for axis in (0, 1)])
    below = float(ground(place[None])[0])
    if not np.isfinite(below):  # above a hole in the terrain
        below = float(np.interp(runout, way.s[np.isfinite(z)], z[np.isfinite(z)]))
    fall = top - below
    numbers.update(top=top, runout=runout, fall=fall, travel_angle=float(np.degrees(np.arctan2(fall, runout))),
                   runout_x=float(place[0]), runout_y=float(place[1]), runout_z=below)
    pressure, flows = maps["peak_pressure"][touched], affected[touched]
    numbers["reach_of_flow"] = way.reach(places[flows], cell)
    for limit in PRESSURES:
        numbers[f"reach_of_{limit / 1e3:g}_kPa"] = way.reach(places[flows & (pressure >= limit)], cell)
    kept = way.s <= max(runout, float(s[flows].max(initial=0.0))) + 10.0 * cell
    profile = {"x": way.points[kept, 0], "y": way.points[kept, 1], "z": z[kept], "s": way.s[kept]}
    station = np.searchsorted(way.s, s)
    for name in ("peak_depth", "peak_speed", "peak_pressure", "deposit_depth"):
        across = np.zeros(len(way.s))
        np.maximum.at(across, station, maps[name][touched])
        profile[name] = across[kept]
    return Hazard(numbers, profile, _line_across(way, places[flows], s[flows], end, place, cell))


def _quantile(s, weight, share, cell):
    """s before which `share` of the weight lies, each piece spread evenly over a cell."""
    ends = np.arange(0.0, s.max() + 2.0 * cell, cell)
    inside = np.histogram(s, ends - 0.5 * cell, weights=weight)[0]
    behind = np.concatenate([[0.0], np.cumsum(inside)])
    return float(np.interp(share * behind[-1], behind, ends - 0.5 * cell))


def _line_across(way, places, s, end, place, cell):
    """Ends (2, 2) of the line across the thalweg at `place` (2,), just before its point `end`, as wide as the area
    affected there."""
    before = way.points[end] - way.points[max(0, end - 5)]
    across = np.array([-before[1], before[0]]) / max(float(np.linalg.norm(before)), 1e-12)
    near = places[np.abs(s - way.s[end]) <= 3.0 * cell]
    side = (near - place) @ across if len(near) else np.zeros(1)
    low, high = min(side.min(), -cell) - cell, max(side.max(), cell) + cell
    return place + np.outer([low, high], across)
