"""From the table `[water]` of a scene to the water in its particles."""

import numpy as np

from snowmpm.errors import InputError
from snowmpm.reading.named_files import existing
from snowmpm.schemes import TRANSFERS
from snowmpm.solids import inside_any
from snowmpm.terrain.raster_values import raster_values
from snowmpm.water.outlets import Outlets
from snowmpm.water.permeability import ICE_DENSITY
from snowmpm.water.pore_water import PoreWater
from snowmpm.water.seepage import Fluid
from snowmpm.water.solved_water import Coupling, SolvedWater

SHARE = {("affine", True): 0.31, ("affine", False): 0.62, ("shape", True): 0.47, ("shape", False): 0.94}
"""s_0 of `water.pore_water` by gradient and by whether the transfer hands C on: with C, grains are stable to (dt w)² =
4, without to 2 (`stepping.time_step`), of which water takes 0.8 of what a step leaves; with "shape", the pressure moves
a grain up to 1.5 times further."""


def pore_water(model):
    """`PoreWater` of a scene, None without. Raises InputError for a material that cannot hold water, and a raster that
    does not fit."""
    spec, scene = model.scene.water, model.scene
    if spec is None:
        return None
    fluid = Fluid(spec.density, spec.bulk_modulus, spec.viscosity, spec.suction)
    ground = None if model.distance is None else (lambda points, time: model.distance.query(points)[0] < 0.0)
    obstacles = model.obstacles
    solid = (lambda points, time: inside_any(obstacles, points, time)) if obstacles else None
    sides = scene.domain.sides(scene.dimension) if scene.domain else {}
    outlets = Outlets(scene.dimension, spec.drained(scene.dimension), ground, solid,
                      any(not obstacle.still for obstacle in obstacles),
                      [name for name, boundary in sides.items() if boundary == "open"])
    if spec.solved:
        coupling = Coupling(spec.split, spec.alpha, spec.tolerance, spec.iterations)
        return SolvedWater(fluid, _permeability(model), outlets, coupling)
    solver = scene.solver
    share = SHARE[solver.gradient, TRANSFERS[solver.transfer].affine] if spec.split == "semi_implicit" else 0.0
    return PoreWater(fluid, _permeability(model), outlets, share)


def water_columns(model, water):
    """Column "water" of the particles at time zero, in the order of the population."""
    scene, population, spec = model.scene, model.population, model.scene.water
    porosity = porosities(scene)[population.material]
    n = len(population.volumes)
    pressure, saturation = np.full(n, spec.pressure), np.full(n, spec.saturation)
    if spec.table is not None:
        depth = spec.table - population.positions[:, -1]
        weight = spec.density * np.linalg.norm(model.first_gravity)
        pressure, saturation = weight * depth, np.where(depth > 0.0, 1.0, spec.saturation)
    return water.columns(porosity, population.volume_ratio, pressure, saturation)


def porosities(scene):
    """Porosity of each material at J = 1."""
    spec, found = scene.water, []
    for name, law in scene.materials.items():
        own = 1.0 - law.density / ICE_DENSITY if spec.porosity is None else spec.porosity
        if not own > 0.0:
            raise InputError.at(f"materials.{name}.density", law.density, f"holds no water: must be below"
                                f" {ICE_DENSITY:g} (ice), or give water.porosity", scene.source)
        found.append(own)
    return np.array(found)


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

    last = []

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
