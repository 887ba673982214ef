"""From the table `[water]` with scheme = "v_w" or "seepage" to water with particles of its own."""

import pkgutil

import numpy as np

from snowmpm.errors import InputError
from snowmpm.particles.population import Population
from snowmpm.setup.flow_water import grain_shares
from snowmpm.water.drag import Darcy, DarcyOfPorosity, Forchheimer, ForchheimerOfPorosity

OF_SCHEME = {"v_w": "snowmpm.mixture.two_velocities:TwoVelocities", "seepage": "snowmpm.seepage.waters:SeepingWaters"}
"""Schemes of water with particles of its own, and what moves it."""


def has_own_water(scene):
    """Whether the water of a scene has particles of its own in the pores."""
    return scene.water is not None and scene.water.scheme in OF_SCHEME


def two_velocities(model):
    """`water.phases.Phases` of a scene. Raises InputError for a material that cannot hold water."""
    spec = model.scene.water
    kind = pkgutil.resolve_name(OF_SCHEME[spec.scheme])
    return kind(spec.density, spec.bulk_modulus, spec.grain_density, grain_shares(model.scene), _drag(spec))


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


def soaked(scene, body, part):
    """`Population` of the grains of a body, and of the water in its pores, in the second velocity
    field of a grid."""
    spec = scene.water
    unknown = [name for name in spec.dry if name not in [each.name for each in scene.bodies]]
    if unknown:
        raise InputError.at("water.dry", unknown[0], "must be names of bodies", scene.source)
    wet = np.full(len(part.volumes), body.name not in spec.dry)
    if spec.table is not None:
        wet &= part.positions[:, -1] < spec.table
    n = grain_shares(scene)[part.material[wet]]
    water = Population(part.positions[wet], n * part.volumes[wet], len(scene.materials), part.velocities[wet],
                       volume_ratio=1.0 / n, field=int(spec.scheme == "v_w"), starts=part.starts[wet])
    return Population.joined([part, water])


def first_columns(model):
    """Column "water" of the particles at time zero, in the order of the population."""
    spec, population = model.scene.water, model.population
    pressure = np.full(len(population.volumes), getattr(spec, "pressure", 0.0))
    if spec.table is not None:
        weight = spec.density * np.linalg.norm(model.first_gravity)
        pressure = np.maximum(weight * (spec.table - population.positions[:, -1]), 0.0)
    return two_velocities(model).columns(population.material, population.volume_ratio, pressure)
