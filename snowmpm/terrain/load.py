"""From the terrain table of a scene to the surface."""

import warnings
from dataclasses import replace

import numpy as np

from snowmpm.errors import InputError
from snowmpm.reading.named_files import existing
from snowmpm.terrain.dams import with_dams
from snowmpm.terrain.defects import defects
from snowmpm.terrain.map_units import plan_metres
from snowmpm.terrain.mesh import mesh_facets
from snowmpm.terrain.plane import plane_facets
from snowmpm.terrain.profile import drawn_out, profile_facets
from snowmpm.terrain.raster import raster_facets, read_raster
from snowmpm.terrain.reference_system import system_beside
from snowmpm.terrain.surface import TerrainSurface


def load_terrain(spec, base_dir=".", *, dimension=None, extent=None):
    """Terrain surface of a scene's terrain table.

    spec: object with `kind` and that kind's attributes
      plane    point (dim,) [m], angle [degrees, dips towards +x], azimuth [degrees from +x towards +y, 3-D; default 0]
      profile  points [[x, z], ...] [m], fillet [m, radius put into every inner corner; default none]; in 3-D drawn out
               along y as far as `extent`
      mesh     file (.stl, .obj, .ply, .glb), metres
      dem      file (.asc, .tif) in a projection, feet converted to metres; elevation_unit "m", "ft" or "us-ft" [default
               what the file says]; dams to raise on it; region with x = [x0, x1], y = [y0, y1] [m], each or both
               optional: the part to use
    base_dir: folder that a relative `file` starts from.
    dimension: 2 or 3; needed for a plane without `point`; a terrain of another dimension is refused.
    extent: plan box (lower, upper) [m] that the scene can reach (heights are ignored). A plane reaches as far; of a
      mesh or a raster only what touches it is kept, so that a large raster costs what the scene uses of it.
    InputError: anything wrong with the input.
    """
    box = None if extent is None else tuple(np.asarray(e, float) for e in extent)
    builder = {"plane": _plane, "profile": _profile, "mesh": _mesh, "dem": _dem}.get(spec.kind)
    if builder is None:
        raise InputError.at("terrain.kind", spec.kind, "must be plane, profile, mesh or dem")
    surface = builder(spec, base_dir, dimension, box)
    if dimension is not None and surface.dim != dimension:
        raise InputError.at("terrain.kind", spec.kind, f"gives a {surface.dim}-D terrain in a {dimension}-D scene")
    return surface


def _plane(spec, base_dir, dimension, box):
    point = spec.get("point")
    if point is None:
        point = np.zeros(dimension or (len(box[0]) if box is not None else 0))
    d = len(point) - 1
    if d not in (1, 2):
        raise InputError("terrain.point: a plane needs a point [x, z] or [x, y, z]")
    if dimension is not None and d + 1 != dimension:
        raise InputError.at("terrain.point", list(point), f"must have {dimension} numbers")
    if box is None:
        raise InputError("terrain: a plane needs the domain, to know how far it reaches")
    angle, azimuth = spec.get("angle") or 0.0, spec.get("azimuth") or 0.0
    return TerrainSurface.of(*plane_facets(point, angle, azimuth, box[0][:d], box[1][:d]))


def _profile(spec, base_dir, dimension, box):
    points, segments = profile_facets(spec.points, spec.get("fillet") or 0.0)
    if dimension != 3:
        return TerrainSurface.of(points, segments)
    if box is None:
        raise InputError("terrain: a profile in 3-D needs the domain, to know how far it is drawn out along y")
    return TerrainSurface.of(*drawn_out(points, (box[0][1], box[1][1])))


def _mesh(spec, base_dir, dimension, box):
    path = existing(spec.file, base_dir, "terrain.file")
    vertices, triangles = mesh_facets(path)
    try:
        surface = TerrainSurface.of(vertices, triangles)
    except InputError:
        raise InputError.at("terrain.file", str(path), "has no triangles with an area") from None
    _tell(path, defects(vertices, triangles, surface))
    system = system_beside(path)
    if system is not None and plan_metres(system, *surface.vertices[:, :2].T, f'terrain.file = "{path}"') != 1.0:
        raise InputError.at("terrain.file", str(path), f"is in {system.unit}: must be in metres")
    surface = replace(surface, system=system)
    return surface if box is None else surface.clipped(*box)


def _dem(spec, base_dir, dimension, box):
    path = existing(spec.file, base_dir, "terrain.file")
    box = _common(box, spec.get("region"))
    raster = read_raster(path, box, elevation_unit=spec.get("elevation_unit"))
    holes = _holes(np.isnan(raster.z))
    _tell(path, [f"{holes} of {raster.z.size} cells without data amid others, where nothing is carried"]
          if holes else [])
    raster = with_dams(raster, spec.get("dams", ()))
    vertices, triangles = raster_facets(raster)
    if len(triangles) == 0:
        raise InputError.at("terrain.file", str(path), "has no three neighbouring cells with data")
    return replace(TerrainSurface.sheet(vertices, triangles), system=raster.system, lattice=raster.lattice())


def _holes(missing):
    """Number of cells without data (rows, columns) that have data on both sides, along a row or a column: a raster that
    was turned, or cut to a valley, has others at its border."""
    there, amid = ~missing, np.zeros(missing.shape, bool)
    for axis in (0, 1):
        before = np.logical_or.accumulate(there, axis)
        behind = np.flip(np.logical_or.accumulate(np.flip(there, axis), axis), axis)
        amid |= before & behind
    return int((missing & amid).sum())


def _tell(path, found):
    if found:
        warnings.warn(f'terrain.file = "{path}": {"; ".join(found)}', stacklevel=2)


def _common(box, region):
    """Plan box inside both the scene's and the raster region's; None where neither bounds anything."""
    if region is None:
        return box
    lower, upper = (np.full(2, -np.inf), np.full(2, np.inf)) if box is None else (box[0][:2].copy(), box[1][:2].copy())
    for axis, name in enumerate("xy"):
        bounds = region.get(name)
        if bounds is not None:
            lower[axis], upper[axis] = max(lower[axis], bounds[0]), min(upper[axis], bounds[1])
    if not (lower < upper).all():
        raise InputError("terrain.region: lies outside the domain")
    return lower, upper
