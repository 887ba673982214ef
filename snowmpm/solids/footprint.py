"""Upright solids over areas in plan, such as buildings: walls, a flat top, and a foot below the ground."""

from itertools import pairwise

import numpy as np

from snowmpm.errors import InputError
from snowmpm.reading.named_files import existing
from snowmpm.seeding.polygons import Polygons
from snowmpm.seeding.region_files import read_features
from snowmpm.seeding.regions import read_regions
from snowmpm.solids.shape import _of_surface

BELOW = 1.0
"""m by which the foot lies below the lowest ground, so that no snow gets under it."""

SAMPLES = 21
"""Places along each side of an area at which the ground is looked at, beside its corners."""


def footprint(spec, dim, base_dir, key, ground):
    """`SolidShape` of a table with file or polygon, and height [m] above the highest ground under each area, on a
    `TerrainSurface`. InputError: no ground, or none under all of it; a file or polygon without an area."""
    if ground is None:
        raise InputError.at(f"{key}.kind", spec.kind, "needs a [terrain] to stand on")
    if spec.file is not None:
        path, label = existing(spec.file, base_dir, f"{key}.file"), f"{key}.file = {str(spec.file)!r}"
        if spec.part is None:
            areas = [region.polygons for region in read_regions(path, f"{key}.file", ground.system)]
        else:  # whole, also where others overlap it
            found = read_features(path, f"{key}.file", ground.system)
            if spec.part > len(found):
                raise InputError.at(f"{key}.part", spec.part, f"{spec.file} holds {len(found)} areas")
            areas = [Polygons.of(found[spec.part - 1].parts, label)]
    else:
        label, areas = f"{key}.polygon", [Polygons.of([[spec.polygon]], f"{key}.polygon")]
    vertices, facets, first = [], [], 0
    for area in areas:
        for polygon in area.geometry.geoms:
            low, high = _levels(area, polygon, ground, label)
            own, triangles = _upright(polygon, low - BELOW, high + spec.height)
            vertices.append(own)
            facets.append(triangles + first)
            first += len(own)
    return _of_surface(np.concatenate(vertices), np.concatenate(facets), f"{label}: the solid")


def _levels(area, polygon, ground, label):
    """Lowest and highest ground [m] under a polygon."""
    corners = np.concatenate([np.asarray(ring.coords) for ring in (polygon.exterior, *polygon.interiors)])
    x, y = (np.linspace(corners[:, a].min(), corners[:, a].max(), SAMPLES) for a in (0, 1))
    grid = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
    places = np.concatenate([corners, grid[area.contains(grid)]])
    height = ground.height(places)
    if np.isnan(height).any():
        raise InputError(f"{label}: lies partly off the terrain, or where it has no data")
    return float(height.min()), float(height.max())


def _upright(polygon, low, high):
    """Vertices (n, 3) and triangles (m, 3) of the walls, the top and the foot over a shapely polygon."""
    import shapely

    vertices, facets = [], []

    def add(triangle):
        facets.append([len(vertices) + k for k in range(3)])
        vertices.extend(triangle)

    for part in shapely.get_parts(shapely.constrained_delaunay_triangles(polygon)):
        a, b, c = np.asarray(part.exterior.coords)[:3]
        for z in (low, high):
            add([(*a, z), (*b, z), (*c, z)])
    for ring in (polygon.exterior, *polygon.interiors):
        corners = np.asarray(ring.coords)
        for a, b in pairwise(corners):
            add([(*a, low), (*b, low), (*b, high)])
            add([(*a, low), (*b, high), (*a, high)])
    return np.array(vertices), np.array(facets)
