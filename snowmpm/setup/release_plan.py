"""Plan area of the snow at the start: the outline of the release in maps, tables and vector files.

A layer has the area of its region. The area of other bodies, of layers without a region, of layers whose thickness is a
raster and of snow from another run follows from their particles: these are sorted into cells of a third of their
spacing, gaps of less than `GAP` cells are closed, and the outermost particles extend by half a spacing. On average the
outline is within a fifth of a spacing of the true one.
"""

import warnings

import numpy as np

from snowmpm import components
from snowmpm.scenes.shapes import ThicknessRaster
from snowmpm.seeding.regions import regions_of

FINE = 3.0
"""Cells a spacing."""

GAP = 4
"""Half of the largest distance [cells] between neighbouring particles of one sheet."""


def release_plan(model):
    """The plan area of the snow of a `Model` in 3-D that flows: a shapely MultiPolygon in scene coordinates [m]."""
    import shapely

    domain = shapely.box(*model.lower[:2], *model.upper[:2])
    parts = [_polygons(model, spec) for spec in model.scene.bodies]
    ends, x = [*model.body_starts, len(model.population.volumes)], model.population.positions
    spacing = model.scene.solver.spacing(3)
    parts = [covered(x[ends[i] : ends[i + 1], :2], spacing) if part is None else part for i, part in enumerate(parts)
             if not components.lies(model.scene, model.scene.bodies[i])]
    whole = shapely.union_all(parts).intersection(domain)
    return shapely.MultiPolygon([part for part in shapely.get_parts(whole) if part.geom_type == "Polygon"])


def _polygons(model, body):
    """The area of the regions of a layer; None for a body without a region of its own."""
    import shapely

    region, taken = body.shape.get("region"), model.taken and body.name in model.taken.bodies
    if body.shape.kind != "layer" or region is None or taken or isinstance(body.shape.top, ThicknessRaster):
        return None
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # warned of when the body was filled
        regions = regions_of(region, model.surface, model.scene.base_dir, "region")
    if any(one.to_border for one in regions):
        return None
    return shapely.union_all([shapely.box(*one.lower, *one.upper) if one.polygons is None else one.polygons.geometry
                              for one in regions])


def covered(plan, spacing):
    """The area, a shapely geometry, that particles at plan positions (n, 2) [m] cover; spacing [m]: between them."""
    import shapely
    from scipy.ndimage import distance_transform_edt  # slow to import

    cell, rim = spacing / FINE, GAP + 2
    first = np.floor(plan.min(axis=0) / cell).astype(np.int64) - rim
    number = np.floor(plan / cell).astype(np.int64) - first
    there = np.zeros(number.max(axis=0) + 1 + rim, bool)
    there[tuple(number.T)] = True
    near = distance_transform_edt(~there) <= GAP
    # Half a spacing is 1.5 cells: the particle's own cell and one more
    held = distance_transform_edt(near) > GAP - 1
    edges = np.diff(np.pad(held, ((0, 0), (1, 1))).astype(np.int8), axis=1)
    (i, low), (_, high) = np.nonzero(edges == 1), np.nonzero(edges == -1)
    x, y0, y1 = (first[k] + numbers for k, numbers in ((0, i), (1, low), (1, high)))
    return shapely.union_all(shapely.box(cell * x, cell * y0, cell * (x + 1), cell * y1))
