"""From the table `[water]` of a scene to water with particles of its own in the pores (`phases.Phases`)."""

import numpy as np

from snowmpm.errors import InputError
from snowmpm.particles.population import Population
from snowmpm.water.drag import Darcy, DarcyOfPorosity, Forchheimer, ForchheimerOfPorosity
from snowmpm.water.pore_fluid import PoreFluid
from snowmpm.water.porosity import porosity_of_grains


def phases(model, kind):
    """`Phases` of a class for a `Model`, whose particles get what they start with in their column "water". Raises
    InputError for a material that cannot hold water."""
    spec, population = model.scene.water, model.population
    found = kind(spec.density, spec.bulk_modulus, spec.grain_density, porosity_of_grains(model.scene), _drag(spec))
    pressure = np.full(len(population.volumes), found.first_pressure(spec))
    if spec.table is not None:
        weight = spec.density * np.linalg.norm(model.first_gravity)
        pressure = np.maximum(weight * (spec.table - population.positions[:, -1]), 0.0)
    population.columns["water"] = found.first_rows(population.material, population.volume_ratio, pressure)
    return found


def laws(model):
    """The law of the water, after those of the scene."""
    return [PoreFluid()]


def with_water(scene, body, part, field=0):
    """`Population` of the grains of a body, and of the water in its pores, in a velocity field of its own."""
    spec = scene.water
    unknown = [name for name in spec.dry if name not in [each.name for each in scene.bodies]]
    if unknown:
        raise InputError.at("water.dry", unknown[0], "must be names of bodies", scene.source)
    wet = np.full(len(part.volumes), body.name not in spec.dry)
    if spec.table is not None:
        wet &= part.positions[:, -1] < spec.table
    n = porosity_of_grains(scene)[part.material[wet]]
    water = Population(part.positions[wet], n * part.volumes[wet], len(scene.materials), part.velocities[wet],
                       volume_ratio=1.0 / n, field=field, starts=part.starts[wet])
    return Population.joined([part, water])


def _drag(spec):
    """Law of `water.drag`."""
    if isinstance(spec.permeability, float):
        mobility = spec.permeability / spec.viscosity
        return Forchheimer(mobility, spec.grain_size, spec.density) if spec.grain_size else Darcy(mobility)

    def mobility_of(n):
        return spec.permeability.of(n) / spec.viscosity

    if spec.grain_size:
        return ForchheimerOfPorosity(mobility_of, spec.grain_size, spec.density)
    return DarcyOfPorosity(mobility_of)
