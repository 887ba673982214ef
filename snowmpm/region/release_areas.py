"""Potential release areas of an elevation raster of any size: `release_terrain` over tiles, `merging` over all.

Tiles are read with the cells around them that their own depend on. In a tile, parts are merged up to a share of the
scale; then those of all tiles together, over the borders of tiles as anywhere. What is in memory is a tile, the rows of
cells along the borders of one row of tiles, and a few numbers a part.
"""

import math
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import shapely

from snowmpm.errors import InputError
from snowmpm.gis.layers import Layer
from snowmpm.gis.vectors import write_geopackage
from snowmpm.region import merging
from snowmpm.region.merging import EAST, NORTH, SIZE, Parts
from snowmpm.region.release_terrain import HALO, can_release, measures
from snowmpm.stages import counted

TILE = 1000
"""Side of a tile [cells]."""
FIRST = 0.1
"""Share of the scale, and of the largest area, up to which parts are merged within a tile."""
HEIGHT, SURFACE, STEEP, WOODED = range(4, 8)
"""Sums over the cells of a part beside those of `merging`: height [m]; area along the ground over that in plan; slope
[degrees]; cells with forest."""
LAYER = "release_areas"


@dataclass(frozen=True)
class ReleaseArea:
    """geometry: MultiPolygon [m]; area in plan, surface along the ground [m2]; slope, aspect (clockwise from north)
    [degrees], altitude [m]: means; lowest, highest [m]; forest: share of it; thickness [m] or None."""

    number: int
    geometry: shapely.MultiPolygon
    area: float
    surface: float
    slope: float
    aspect: float
    altitude: float
    lowest: float
    highest: float
    forest: float
    thickness: float | None = None

    @property
    def volume(self):
        """Of the snow [m3]; None without a thickness."""
        return None if self.thickness is None else self.surface * self.thickness

    def fields(self, scenario):
        """Attributes, by name."""
        return {"id": self.number, "scenario": scenario, "area_m2": round(self.area, 1),
                "surface_m2": round(self.surface, 1), "slope_deg": round(self.slope, 2),
                "aspect_deg": round(self.aspect, 1), "altitude_m": round(self.altitude, 1),
                "lowest_m": round(self.lowest, 1), "highest_m": round(self.highest, 1),
                "forest_share": round(self.forest, 3),
                "thickness": None if self.thickness is None else round(self.thickness, 3),
                "volume_m3": None if self.volume is None else round(self.volume, 1)}


@dataclass
class _Tile:
    rows: tuple
    columns: tuple
    first: int
    """Number of its first part."""
    file: Path


def release_areas(elevations, rule, forest=None, protects=True, rows=None, columns=None, scratch=None):
    """List of `ReleaseArea`s of open `Elevations`, from the north.

    rule: `release_terrain.Rule`; forest: `Forest` or None; protects: whether nothing releases in it; rows, columns:
    first and last + 1 cell, all by default. Raises InputError where the cells are too coarse for basins.
    """
    grid = elevations.grid
    if grid.cell > 30.0 or grid.cell < 0.5:
        raise InputError(f"{elevations.path}: has cells of {grid.cell:g} m: release areas need 0.5 to 30 m, best 5 m")
    rows, columns = rows or (0, grid.rows), columns or (0, grid.columns)
    with tempfile.TemporaryDirectory(dir=scratch) as folder:
        tiles, parts, ends = _parts(elevations, rule, forest, protects, rows, columns, Path(folder))
        if not len(parts.sums):
            return []
        whole, label = merging.merge(parts, grid.cell, rule.scale, rule.largest)
        lowest, highest = np.full(len(whole.sums), np.inf), np.full(len(whole.sums), -np.inf)
        np.minimum.at(lowest, label, ends[:, 0])
        np.maximum.at(highest, label, ends[:, 1])
        area = whole.sums[:, SIZE] * grid.cell**2
        kept = (area >= rule.smallest) & (whole.sums[:, STEEP] / whole.sums[:, SIZE] >= rule.mean)
        number = np.where(kept, np.cumsum(kept), 0).astype(np.int32)
        outlines = _outlines(tiles, number[label], grid)
    index = np.flatnonzero(kept)
    return [_area(number[k], outlines[int(number[k])], whole.sums[k], lowest[k], highest[k], grid.cell) for k in index]


def _area(number, geometry, sums, lowest, highest, cell):
    n = sums[SIZE]
    aspect = math.degrees(math.atan2(sums[EAST], sums[NORTH])) % 360.0
    return ReleaseArea(int(number), geometry, n * cell**2, sums[SURFACE] * cell**2, sums[STEEP] / n, aspect,
                       sums[HEIGHT] / n, float(lowest), float(highest), sums[WOODED] / n)


def _parts(elevations, rule, forest, protects, rows, columns, folder):
    """(list of `_Tile`, `Parts` of all of them, their lowest and highest cells (n, 2))."""
    tiles, sums, edges, borders, ends = [], [], [], [], []
    above, first = {}, 0
    spans = [(r, min(r + TILE, rows[1])) for r in range(rows[0], rows[1], TILE)]
    across = [(c, min(c + TILE, columns[1])) for c in range(columns[0], columns[1], TILE)]
    jobs = [(r, c) for r in spans for c in across]
    beside = None
    for row, column in counted(jobs, "looking for release areas", "tiles"):
        number, parts, down, own = _tile(elevations, rule, forest, protects, row, column)
        number = np.where(number >= 0, number + first, -1)
        if column[0] == across[0][0]:
            beside = None
        for before, here, sign in ((beside, (number[:, 0], down[0, :, 0]), 1.0),
                                   (above.get(column), (number[0], down[1, 0]), -1.0)):
            if before is not None:
                pairs, border = _over(before, here, sign)
                edges.append(pairs)
                borders.append(border)
        beside = number[:, -1], down[0, :, -1]
        above[column] = number[-1], down[1, -1]
        file = folder / f"{len(tiles)}.npy"
        np.save(file, number.astype(np.int32))
        tiles.append(_Tile(row, column, first, file))
        sums.append(parts.sums)
        edges.append(parts.edges + first)
        borders.append(parts.borders)
        ends.append(own)
        first += len(parts.sums)
    pairs, border = merging.edges_of(*np.concatenate(edges).T, np.concatenate(borders))
    return tiles, Parts(np.concatenate(sums), pairs, border), np.concatenate(ends)


def _over(before, here, sign):
    """(edges, borders) over the border of two tiles: numbers and downhill parts of the cells on either side."""
    both = (before[0] >= 0) & (here[0] >= 0)
    divides = sign * (here[1][both] - before[1][both])
    return np.stack([before[0][both], here[0][both]], axis=1), np.stack([np.ones(len(divides)), divides], axis=1)


def _tile(elevations, rule, forest, protects, rows, columns):
    """(numbers of parts (rows, columns), `Parts`, downhill vectors, lowest and highest (n, 2)) of a tile."""
    grid = elevations.grid
    wide = (rows[0] - HALO, rows[1] + HALO), (columns[0] - HALO, columns[1] + HALO)
    z = elevations.read(*wide)
    inner = np.s_[HALO:-HALO, HALO:-HALO]
    shape = rows[1] - rows[0], columns[1] - columns[0]
    if not np.isfinite(z).any():
        return np.full(shape, -1), Parts(np.empty((0, 8)), np.empty((0, 2), int), np.empty((0, 2))), \
            np.zeros((2, *shape)), np.empty((0, 2))
    found = measures(z, grid.cell)
    woods = None if forest is None else forest.mask(grid, *wide)
    mask = can_release(z, found, rule, woods if protects else None)[inner] & np.isfinite(found.slope[inner])
    down, slope, z = found.down[(slice(None), *inner)], found.slope[inner], z[inner]
    wooded = np.zeros(shape) if woods is None else woods[inner].astype(float)
    others = (z, 1.0 / np.cos(np.radians(slope)), slope, wooded)
    parts, number = merging.cells_as_parts(mask, down, others)
    parts, label = merging.merge(parts, grid.cell, FIRST * rule.scale, FIRST * rule.largest)
    number = np.where(number >= 0, label[np.maximum(number, 0)], -1) if len(label) else number
    ends = np.stack([np.full(len(parts.sums), np.inf), np.full(len(parts.sums), -np.inf)], axis=1)
    np.minimum.at(ends[:, 0], number[mask], z[mask])
    np.maximum.at(ends[:, 1], number[mask], z[mask])
    return number, parts, down, ends


def _outlines(tiles, number, grid):
    """{number: MultiPolygon [m]} of the parts with a number > 0, along the sides of cells."""
    from rasterio import features
    from rasterio.transform import Affine

    pieces: dict[int, list] = {}
    for tile in counted(tiles, "outlining release areas", "tiles"):
        own = np.load(tile.file)
        final = np.where(own >= 0, number[np.maximum(own, 0)], 0).astype(np.int32)
        if not final.any():
            continue
        for shape, value in features.shapes(final, final > 0, connectivity=4, transform=Affine.identity()):
            outline = shapely.transform(shapely.geometry.shape(shape), lambda at, tile=tile: np.column_stack([
                at[:, 0] + tile.columns[0], at[:, 1] + tile.rows[0]]))
            pieces.setdefault(int(value), []).append(outline)
    return {value: _on_map(parts, grid) for value, parts in pieces.items()}


def _on_map(parts, grid):
    """MultiPolygon [m] of polygons in whole cells."""
    whole = shapely.union_all(parts) if len(parts) > 1 else parts[0]
    whole = shapely.MultiPolygon([whole]) if whole.geom_type == "Polygon" else whole
    placed = shapely.transform(whole, lambda at: np.column_stack([
        np.round(grid.west + grid.cell * at[:, 0], 3), np.round(grid.north - grid.cell * at[:, 1], 3)]))
    return shapely.remove_repeated_points(placed)


def described(number, geometry, elevations, thick=None, key="areas"):
    """`ReleaseArea` of a polygon on open `Elevations`. Raises InputError for one without known ground under it."""
    from rasterio.features import geometry_mask

    grid = elevations.grid
    west, south, east, north = shapely.intersection(geometry, shapely.box(*grid.bounds)).bounds
    rows, columns = grid.rows_of(south, north), grid.columns_of(west, east)
    z = elevations.read((rows[0] - HALO, rows[1] + HALO), (columns[0] - HALO, columns[1] + HALO))
    found, inner = measures(z, grid.cell), np.s_[HALO:-HALO, HALO:-HALO]
    inside = geometry_mask([geometry], (rows[1] - rows[0], columns[1] - columns[0]),
                           grid.transform(rows[0], columns[0]), all_touched=True, invert=True)
    slope, z = found.slope[inner], z[inner]
    inside &= np.isfinite(slope)
    if not inside.any():
        raise InputError(f"{key}: area {number} at x = {west:.0f} m, y = {south:.0f} m lies where the terrain has no"
                         " heights")
    stretch = float((1.0 / np.cos(np.radians(slope[inside]))).mean())
    east, north = found.down[(slice(None), *inner)][:, inside].sum(axis=1)
    return ReleaseArea(number, geometry, geometry.area, geometry.area * stretch, float(slope[inside].mean()),
                       math.degrees(math.atan2(east, north)) % 360.0, float(z[inside].mean()), float(z[inside].min()),
                       float(z[inside].max()), 0.0, thick)


def write(areas, path, scenario, system=None):
    """Write areas as a GeoPackage; -> its path. Raises InputError where there are none."""
    if not areas:
        raise InputError(f"{path}: no release areas: no ground is steep enough")
    layer = Layer(LAYER, "MultiPolygon", [(one.geometry, one.fields(scenario)) for one in areas])
    return write_geopackage(path, [layer], system and system.wkt)
