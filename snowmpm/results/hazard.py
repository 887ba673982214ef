"""Numbers of hazard mapping from the maps of a run (defined in `snowmpm.quantities.table`).

Ways down: to each cell the way from the top of the release that took the snow least time (`snowmpm.results.ways`).
Where releases do not meet, each has its own top.

Run-out point: at the length of the ways before which `RUNOUT_SHARE` of the snow lies at the end, so that no single
particle sets it; of the deposited cells there, the middle of the tongue with the most snow. It lies in the deposit.
Thalweg: the way down to it, smoothed by a cell, less where it would leave the flow. Run-out: length of the thalweg in
plan. Travel angle (Fahrboeschung) alpha = atan(fall / run-out), fall from the top of the release to the ground at the
run-out point. That is the practice of hazard mapping: the furthest point of the deposit, the length along the path to
it, and the angle between them; a share of 1 % of the snow beyond it keeps it from being that of a few grains.
Furthest deposit: the deposited cell furthest along the thalweg, which is extended straight for it.

s [m] is the length along the thalweg; a map cell belongs to the s of its nearest point.

Affected area: where the flow depth once was at least a tenth of the mean release depth. area_above_1_kPa, where the
pressure also reached 1 kPa, is the affected area of AvaFrame's AIMEC with its default threshold. The reach of an area
is the largest s of the corners of its cells.

Areas are sums of map cells, except that of the release, whose outline is known: cells that it only touches count in
part. Cells are classified by the maps as stored, in float32, so that readers of the file find the same.
"""

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import shapely
from scipy.ndimage import gaussian_filter1d
from scipy.spatial import cKDTree

from snowmpm.quantities.classes import PRESSURES, classes_of
from snowmpm.quantities.thalweg import ahead_of
from snowmpm.results.ways import Cells, end_of, straightened, ways_down

RUNOUT_SHARE = 0.99
"""Share of the snow before the run-out line."""

TOP_SHARE = 0.05
"""Share of the height of the release that counts as its top."""

TOP_POINTS = 4.0
"""Points per side of a map cell at which the terrain under the release is searched for its top."""

MOST_TOP_POINTS = 300
"""Approximate largest number of such points along a side of the release."""

CORNERS = np.array([[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]])

SMOOTHING = 1.0
"""Standard deviation [map cells] of the smoothing of the thalweg: more cuts corners over side walls."""

FINE = 0.25
"""Spacing [map cells] of points at which a line is asked whether it lies in the flow, and whether it climbs."""

DRY = 0.01
"""Share of the thalweg that smoothing may move out of the flow."""

SHORT = 3.0
"""Length [map cells] up to which nothing is said to have moved."""


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


def thalweg(line, cell, inside, reach):
    """`Thalweg` of a line (n, 2) of map cells [m], smoothed, and extended straight by `reach` [m]; and its own length
    [m]. inside: function of plan positions (k, 2) -> whether they lie in the flow."""
    line = _smoothed_inside(line, cell, inside)
    longer = np.concatenate([line, line[-1] + cell * np.arange(1, int(reach / cell) + 2)[:, None] * ahead_of(line)])
    s = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(longer, axis=0), axis=1))])
    return Thalweg(longer, s), float(s[len(line) - 1])


def _smoothed_inside(line, cell, inside):
    """A line smoothed as far as no more than `DRY` of it leaves the flow, or than did before."""
    def dry(points):
        return 1.0 - float(inside(equally_spaced(points, FINE * cell)).mean())

    for width in (SMOOTHING, 0.5 * SMOOTHING):
        found = equally_spaced(smoothed(equally_spaced(line, cell), width), cell)
        if dry(found) <= max(DRY, dry(line)):
            return found
    return equally_spaced(line, cell)


def equally_spaced(line, step):
    """Points every `step` [m] along a line (n, 2)."""
    s = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
    at = np.arange(0.0, s[-1] + step, step).clip(max=s[-1])
    return np.column_stack([np.interp(at, s, line[:, axis]) for axis in (0, 1)])


def smoothed(line, width):
    """The line (n, 2) smoothed over so many points; its ends stay."""
    straight = line[0] + np.linspace(0.0, 1.0, len(line))[:, None] * (line[-1] - line[0])
    # The deviation from a straight line is zero at both ends; antisymmetric mirroring keeps it so
    bend = line - straight
    mirrored = np.concatenate([-bend[:0:-1], bend, -bend[-2::-1]])
    smooth = gaussian_filter1d(mirrored, width, axis=0)[len(line) - 1 : 2 * len(line) - 1]
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
    release: Any = None

    def record(self):
        """As plain lists and numbers, for a file."""
        profile = {name: [round(float(v), 3) for v in values] for name, values in self.profile.items()}
        return {"numbers": self.numbers, "classes": self.classes, "profile": profile, "release": rings(self.release),
                "runout_line": None if self.line is None else np.round(self.line, 3).tolist()}


def rings(area):
    """[[ring, hole, ...], ...] of the polygons of a shapely geometry, each a list of [x, y]."""
    return [[[list(corner) for corner in ring.coords] for ring in (part.exterior, *part.interiors)]
            for part in shapely.get_parts(area)]


def assess(maps, lower, cell, flow_depth, whole, ground, release):
    """Numbers of hazard mapping of a run -> `Hazard`.

    maps: by name, (columns along x, rows along y), zero without snow
    (`snowmpm.results.maps.PeakMaps.values`); lower (2,), cell [m]: their corner and the side of a cell; flow_depth [m]:
    thinner is not affected; whole: numbers of all the snow, copied as they are (release_mass, deposit_mass,
    moving_share, momentum_share, left_share);
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
    found = _runout(maps, lower, cell, numbers, affected, deposited, ground, tops_of(release, cell, ground))
    return Hazard(numbers, {}, None, classes, release) if found is None else replace(found, classes=classes,
                                                                                     release=release)


def tops_of(release, cell, ground):
    """`top_of` each part of the release, the highest first."""
    found = [top_of(part, cell, ground) for part in shapely.get_parts(release) if not part.is_empty]
    return sorted((top for top in found if top is not None), key=lambda top: -top[0])


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


def _runout(maps, lower, cell, numbers, affected, deposited, ground, tops):
    """Run-out and profile along the thalweg, added to the numbers -> `Hazard`; None where nothing moved."""
    peak, deposit = maps["peak_depth"], maps["deposit_depth"]
    touched = peak > 0.0
    if not tops or not (maps["peak_speed"] > 0.0).any():
        return None
    middles = lower + cell * (np.stack(np.indices(peak.shape), axis=-1) + 0.5)
    places = middles[touched]
    height = np.full(peak.shape, np.nan)
    height[touched] = ground(places)
    height = np.where(np.isfinite(height), height, np.nanmax(height[touched], initial=-1e9))
    arrival = maps.get("arrival_time", np.zeros_like(peak))
    arrival = np.where(affected & np.isfinite(arrival), arrival, np.inf)
    cells = Cells(touched, affected, maps["peak_speed"], arrival, height, cell)
    starts = np.argwhere(touched)[cKDTree(places).query(np.array([place for _, place in tops]))[1]]
    ways = ways_down(cells, starts)
    snow = deposit[touched].astype(float)
    end = end_of(ways, cells, snow, (deposited & affected)[touched], RUNOUT_SHARE)
    if end is None:  # a flow so thin that nothing counts as its deposit
        end = end_of(ways, cells, snow, snow > 0.0, RUNOUT_SHARE)
    if end is None:
        return None
    line = lower + cell * (straightened(ways.cells[ways.to(end)], cells) + 0.5)
    if np.linalg.norm(line[-1] - line[0]) < SHORT * cell:
        return None
    high, line[0] = min(tops, key=lambda top: np.linalg.norm(top[1] - line[0]))
    flow = _Flow(lower, cell, affected)
    way, runout = thalweg(line, cell, flow.holds, float(np.linalg.norm(np.ptp(places, axis=0))))
    return _along(way, runout, maps, places, flow, numbers, high, ground)


@dataclass(frozen=True)
class _Flow:
    """The affected cells (columns, rows) of a map with this corner (2,) and side [m]."""

    lower: np.ndarray
    cell: float
    affected: np.ndarray

    def holds(self, places):
        """Which places (k, 2) lie in it."""
        at = np.floor((places - self.lower) / self.cell).astype(int)
        inside = ((at >= 0) & (at < self.affected.shape)).all(axis=1)
        return inside & self.affected[tuple(np.clip(at, 0, np.array(self.affected.shape) - 1).T)]


def _along(way, runout, maps, places, flow, numbers, top, ground):
    """Numbers and profile along the thalweg, whose own length is the run-out, added to the numbers."""
    touched, cell = maps["peak_depth"] > 0.0, flow.cell
    s = way.along(places)
    end = int(np.searchsorted(way.s, runout - 1e-6 * cell))
    place = way.points[end]
    z = ground(way.points)
    below = float(z[end]) if np.isfinite(z[end]) else float(np.interp(runout, way.s[np.isfinite(z)], z[np.isfinite(z)]))
    fall = top - below
    numbers.update(top=top, runout=runout, fall=fall, travel_angle=float(np.degrees(np.arctan2(fall, runout))),
                   runout_x=float(place[0]), runout_y=float(place[1]), runout_z=below)
    pressure, flows = maps["peak_pressure"][touched], flow.affected[touched]
    numbers["reach_of_flow"] = way.reach(places[flows], cell)
    for limit in PRESSURES:
        numbers[f"reach_of_{limit / 1e3:g}_kPa"] = way.reach(places[flows & (pressure >= limit)], cell)
    lies = np.flatnonzero(flows & (maps["deposit_depth"][touched] >= numbers["flow_depth"]))
    if len(lies):
        far = places[lies[np.argmax(s[lies])]]
        numbers.update(deposit_reach=way.reach(places[lies], cell), deposit_reach_x=float(far[0]),
                       deposit_reach_y=float(far[1]), deposit_reach_z=float(ground(far[None])[0]))
    fine = equally_spaced(way.points[: end + 1], FINE * cell)
    heights = ground(fine)
    heights = heights[np.isfinite(heights)]
    numbers["thalweg_dry"] = 1.0 - float(flow.holds(fine).mean())
    numbers["thalweg_climb"] = float((heights - np.minimum.accumulate(heights)).max(initial=0.0))
    kept = np.arange(len(way.s)) <= end
    profile = {"x": way.points[kept, 0], "y": way.points[kept, 1], "z": z[kept], "s": way.s[kept]}
    station = np.searchsorted(way.s, s)
    for name in ("peak_depth", "peak_speed", "peak_pressure", "deposit_depth"):
        across = np.zeros(len(way.s))
        np.maximum.at(across, station, maps[name][touched])
        profile[name] = across[kept]
    return Hazard(numbers, profile, _line_across(way, places[flows], s[flows], end, place, cell))


def _line_across(way, places, s, end, place, cell):
    """Ends (2, 2) of the line across the thalweg at `place` (2,), just before its point `end`, as wide as the area
    affected there."""
    before = way.points[end] - way.points[max(0, end - 5)]
    across = np.array([-before[1], before[0]]) / max(float(np.linalg.norm(before)), 1e-12)
    near = places[np.abs(s - way.s[end]) <= 3.0 * cell]
    side = (near - place) @ across if len(near) else np.zeros(1)
    low, high = min(side.min(), -cell) - cell, max(side.max(), cell) + cell
    return place + np.outer([low, high], across)
