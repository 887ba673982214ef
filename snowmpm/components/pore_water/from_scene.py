"""From the table `[water]` of a scene to the water in its particles."""

from typing import Any

import numpy as np

from snowmpm.components.pore_water.flow import Fluid
from snowmpm.components.pore_water.outlets import Outlets
from snowmpm.errors import InputError
from snowmpm.reading.named_files import existing
from snowmpm.solids import inside_any
from snowmpm.terrain.raster_values import raster_values
from snowmpm.water.porosity import porosity_of_snow


def parts(model):
    """(`Fluid`, function of the permeability, `Outlets`) of the water of a `Model`. Raises InputError for a raster that
    does not fit."""
    spec, scene, obstacles = model.scene.water, model.scene, model.obstacles
    fluid = Fluid(spec.density, spec.bulk_modulus, spec.viscosity, spec.suction)
    ground = None if model.distance is None else (lambda points, time: model.distance.query(points)[0] < 0.0)
    solid = (lambda points, time: inside_any(obstacles, points, time)) if obstacles else None
    sides = scene.domain.sides(scene.dimension) if scene.domain else {}
    outlets = Outlets(scene.dimension, spec.drained(scene.dimension), ground, solid,
                      any(not obstacle.still for obstacle in obstacles),
                      [name for name, boundary in sides.items() if boundary == "open"])
    return fluid, _permeability(model), outlets


def filled(model, water):
    """`water`, a `step.FilledPores` of a `Model`, whose particles get what they start with. Raises InputError for a
    material that cannot hold water."""
    scene, population, spec = model.scene, model.population, model.scene.water
    porosity = porosity_of_snow(scene)[population.material]
    n = len(population.volumes)
    pressure, saturation = np.full(n, spec.pressure), np.full(n, spec.saturation)
    if spec.table is not None:
        depth = spec.table - population.positions[:, -1]
        weight = spec.density * np.linalg.norm(model.first_gravity)
        pressure, saturation = weight * depth, np.where(depth > 0.0, 1.0, spec.saturation)
    population.columns["water"] = water.first_rows(porosity, population.volume_ratio, pressure, saturation)
    return water


def _permeability(model):
    """Function (places (k, dim) [m], porosity (k,)) -> K (k,) [m2]."""
    value, scene = model.scene.water.permeability, model.scene
    if isinstance(value, float):
        return lambda places, porosity: np.full(len(places), value)
    if value.law != "raster":
        return lambda places, porosity: value.of(porosity)
    key = "water.permeability.file"
    path = existing(value.file, scene.base_dir, key)
    system = model.surface.system if model.surface else None

    last: list[Any] = []

    def of_raster(places, porosity):
        if last and np.array_equal(last[0], places):
            return last[1]
        found = raster_values(path, key, "values of the permeability", system, places[:, :2], filled=True).values
        if not (found > 0.0).all():
            x, y = places[np.argmin(found > 0.0), :2]
            raise InputError.at(key, value.file, f"holds {found.min():g} at x = {x:.6g}, y = {y:.6g}: must be above 0",
                                scene.source)
        last[:] = places, found
        return found

    of_raster(model.population.positions, None)
    return of_raster
