"""Layers of snow on the ground: bounds, checks, and their rows or sheets of particles."""

import numpy as np

from snowmpm import memory
from snowmpm.errors import InputError
from snowmpm.keys import Keyed
from snowmpm.seeding.attributes import ABSENT
from snowmpm.seeding.profile_layer import profile_layer
from snowmpm.seeding.regions import regions_of
from snowmpm.seeding.terrain_layer import terrain_layer
from snowmpm.seeding.thickness import RasterThickness


def layer_seeds(spec, surface, *, dx, spacing, sampling, rng, base_dir, key, columns=False,
                rim=None):
    """Positions (n, dim) [m] and volumes (n,) of a layer from `bottom` to `top` [m] above the terrain, normal to it.

    spec: bottom (default 0), top (a number; None or "file": bottom + the thickness in the region file; with a `file`:
    bottom + the values of that raster), region.
    columns: one sheet of particles, as thick as the layer, which a raster of thickness needs.
    InputError: top not above bottom, thinner than half a cell, region off the terrain, no thickness in the file.
    """
    if surface is None:
        raise InputError.at(f"{key}.kind", "layer", "needs a [terrain] to lie on")
    bottom, top = spec.get("bottom") or 0.0, spec.get("top")
    if bottom < 0:
        raise InputError.at(f"{key}.bottom", bottom, "must be >= 0 (height above the terrain)")
    raster = RasterThickness.of(top, base_dir, f"{key}.top.file", surface.system) if isinstance(top, Keyed) else None
    area = spec.get("region")
    regions = [raster.region(surface)] if raster and area is None else regions_of(
        area, surface, base_dir, f"{key}.region", spec.get("attribute"))
    positions, volumes = [], []
    for region in regions:
        if raster is None:
            upper = _top(bottom, top, region, key)
            _check_thickness(bottom, upper, 0.0 if columns else dx, key)
        count = region.area() / spacing**2 if columns else region.area() * (upper - bottom) / spacing**surface.dim
        memory.require(memory.PER_PARTICLE[surface.dim] * count, f"{key}: its particles")
        build = profile_layer if surface.dim == 2 else terrain_layer
        sheets = {"columns": True, "rim": rim} if columns else {}
        if raster is not None:
            upper, sheets = bottom, {"columns": True, "thickness": raster.at}
        x, v = build(surface, region, bottom, upper, dx=dx, spacing=spacing, sampling=sampling, rng=rng, **sheets)
        positions.append(x)
        volumes.append(v)
    if not sum(map(len, volumes)):
        raise InputError.at(f"{key}.top.file", str(top.file), "has no snow in the region")
    return np.concatenate(positions), np.concatenate(volumes)


def _top(bottom, top, region, key):
    if top is not None and top != "file":
        return float(top)
    if region.thickness is None:
        absent = region.flaw.startswith(ABSENT)
        how = f"{'name another with attribute' if absent else 'mend the file'}, or give top in metres"
        raise InputError.at(f"{key}.top", top, f"{region.label}: {region.flaw}: {how}")
    return bottom + region.thickness


def _check_thickness(bottom, top, dx, key):
    thickness = top - bottom
    if not thickness > 0:
        raise InputError.at(f"{key}.top", top, f"must be larger than bottom = {bottom:g}")
    if thickness < 0.5 * dx * (1 - 1e-9):
        raise InputError.at(
            f"{key}.top",
            top,
            f"the layer is {thickness:g} m thick, less than half a cell of dx = {dx:g} m: "
            f"it needs solver.dx <= {2 * thickness:g} m, or a thicker layer",
        )
