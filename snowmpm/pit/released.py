"""What a slab run has released: area and thickness, as a polygon and a raster that `depth` takes as its release.

Cells are CELL grid cells wide. One is released where most of the snow that began in it has moved by more than MOVED
grid cells. Its thickness, normal to the slope, is the volume that began in it over its area on the ground. Points of an
interface (`snowmpm docs interface`) stand for a thin layer and do not count.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from snowmpm.errors import InputError
from snowmpm.io.ground_maps import Map
from snowmpm.reading.toml_text import tables

CELL = 2.0
"""Side of a cell [grid cells]."""
MOVED = 1.0
"""Displacement [grid cells] from which on a particle has left; the snow that stays creeps by a tenth of it."""
MOST = 0.5
"""Share of a cell's particles."""
THINNEST = 0.5
"""Depth of a cell over the median one below which it is an edge: snow of a cell beside it, which gets its volume."""


@dataclass(frozen=True)
class Released:
    """raster: `Map` of the thickness normal to the slope [m], NaN where nothing went; area: of its cells in plan [m2];
    thickness: its mean [m]; volume [m3]; slab: area of all snow at the start [m2]; edge: share of the border of the
    area that lies on the border of that snow."""

    raster: Map
    area: float
    thickness: float
    volume: float
    slab: float
    edge: float

    def outline(self, origin: Any) -> Any:
        """MultiPolygon of the area in map coordinates [m]. origin: of the run."""
        from snowmpm.gis.outlines import outline

        return outline(np.isfinite(self.raster.values), self.raster, origin)


def released_by(run: Any) -> Released:
    """`Released` by a `snowmpm.io.Run` in 3-D between its first and its last frame.

    Raises InputError for a run without maps, frames or identities of particles, and for one that released nothing.
    """
    volume = (run.hazard or {}).get("numbers", {}).get("release_volume")
    if volume is None:
        raise InputError(f"{run.path}: no release volume: runs in three dimensions on terrain have it, at their end")
    if not {"id", "material"} <= set(run.field_names):
        raise InputError(f"{run.path}: particles are not told apart: output.fields must have \"id\" and \"material\"")
    dx = run.provenance["dx"]
    first, last = (run.frame(i, ["id", "material"]) for i in (0, -1))
    thick = ~np.isin(np.asarray(first.fields["material"]), _thin_materials(run))
    places, ways = first.points[thick].astype(float), _ways(first, last, MOVED * dx)[thick]
    cell = CELL * dx
    lower = cell * np.floor(places[:, :2].min(axis=0) / cell)
    columns, rows = np.floor((places[:, :2] - lower) / cell).astype(int).T
    count, gone = (np.zeros((rows.max() + 1, columns.max() + 1)) for _ in range(2))
    np.add.at(count, (rows, columns), 1.0)
    np.add.at(gone, (rows, columns), ways > MOVED * dx)
    snow = count >= THINNEST * np.median(count[count > 0.0])
    released = snow & (gone >= MOST * count)
    if not released.any():
        raise InputError(f"{run.path}: it released nothing: no part of the snow moved by more than {MOVED * dx:.2g} m"
                         f" until {run.times[-1]:g} s")
    went = float(np.sum(ways > MOVED * dx) * volume / len(places))
    depth = count * went / count[released].sum() / cell**2
    x0, y0 = (float(value) for value in lower + 0.5 * cell)
    thickness = np.where(released, depth * _cosine(run, x0, y0, cell, count.shape[::-1]), np.nan)
    return Released(
        Map(thickness, x0, y0, float(cell), "m"), float(released.sum() * cell**2), float(np.nanmean(thickness)), went,
        float(snow.sum() * cell**2), _edge(released, snow))


def _thin_materials(run):
    """Numbers of the materials of bodies that are interfaces."""
    scene = tables(run.provenance.get("scene", ""), f"{run.path}: its scene")
    names = list(run.provenance.get("materials", ()))
    thin = {body.get("material") for body in scene.get("bodies", []) if body.get("interface")}
    return [names.index(name) for name in thin if name in names]


def _ways(first, last, far):
    """How far each particle of the first frame has moved [m]; further than `far` where it left the model."""
    numbers, order = np.unique(np.asarray(last.fields["id"]), return_index=True)
    own = np.asarray(first.fields["id"])
    place = np.minimum(np.searchsorted(numbers, own), len(numbers) - 1)
    ways = np.linalg.norm(last.points[order[place]].astype(float) - first.points, axis=1)
    return np.where(numbers[place] == own, ways, 2.0 * far)


def _cosine(run, x0, y0, cell, shape):
    """Of the slope of the ground, in each cell; 1 where there is none."""
    from snowmpm.render.relief import height_raster

    terrain = run.terrain
    if terrain is None or terrain.facets.shape[1] != 3:
        return np.ones(shape[::-1])
    heights = height_raster(terrain.vertices.astype(float), terrain.facets, np.array([x0, y0]), cell, shape)
    if heights is None:
        return np.ones(shape[::-1])
    north, east = np.gradient(heights, cell)
    return 1.0 / np.sqrt(1.0 + np.nan_to_num(north) ** 2 + np.nan_to_num(east) ** 2)


def _edge(gone, snow):
    """Share of the sides of released cells, towards unreleased ones, beyond which lies no snow at all."""
    outer, inner = 0, 0
    for axis in (0, 1):
        for step in (1, -1):
            beside_gone, beside_snow = (np.roll(np.pad(one, 1), step, axis)[1:-1, 1:-1] for one in (gone, snow))
            border = gone & ~beside_gone
            outer += int((border & ~beside_snow).sum())
            inner += int((border & beside_snow).sum())
    return outer / max(1, outer + inner)


def write(found: Released, run: Any, folder: Any, name: str = "release") -> list[Any]:
    """Write NAME.tif (thickness) and NAME.gpkg (outline with its attribute `thickness`); -> their paths. Needs the
    extra gis."""
    from snowmpm import gis
    from snowmpm.gis.layers import Layer
    from snowmpm.io.geotiff import write_geotiff

    crs = run.provenance.get("crs")
    raster = write_geotiff(folder / f"{name}.tif", found.raster, run.origin, crs,
                           "thickness of the released slab, normal to the slope [m]", {"run": run.name})
    about = {"thickness": round(found.thickness, 3), "area_m2": round(found.area, 1),
             "volume_m3": round(found.volume, 1), "run": run.name}
    layers = [Layer("release", "MultiPolygon", [(found.outline(run.origin), about)])]
    return [raster, gis.write_geopackage(folder / f"{name}.gpkg", layers, crs)]
