"""Initial stress of a scene's particles, and the corresponding elastic strain."""

import numpy as np

from snowmpm.errors import InputError
from snowmpm.materials import pack
from snowmpm.setup.initial_stress import geostatic_stress, overburden


def stress_from_weight(model):
    """Geostatic stress and the corresponding elastic strain of every particle."""
    scene, population = model.scene, model.population
    if model.gravity is not None and not np.any(model.first_gravity):
        raise InputError.at("initial.stress", scene.initial.stress, "needs gravity at time 0, where it is 0 here",
                            scene.source)
    shapes = [(body.shape if body.shape.kind == "layer" else None, scene.materials[body.material].density)
              for body in scene.bodies]
    query = model.distance.query if model.distance else None
    spacing = scene.solver.spacing(scene.dimension)
    if scene.saw_test:
        load, normals = _load_in_column(scene, population.positions)
    else:
        load, normals = overburden(shapes, population.positions, model.body_of, query, model.first_gravity,
                                   scene.solver.dx, spacing)
    given = scene.initial.lateral_pressure
    of_laws = [law.lateral_pressure if given is None else given for law in model.laws]
    k0 = np.array([*of_laws, 0.0])[population.material]  # particles of water, the last material, get no stress
    tau = geostatic_stress(population.positions, load, normals, model.first_gravity, k0)
    _give_stress(model, tau)


def uniform_pressure(model):
    """The same isotropic pressure everywhere."""
    n = len(model.population.volumes)
    _give_stress(model, np.tile(-model.scene.initial.pressure * np.eye(3), (n, 1, 1)))


def _give_stress(model, tau):
    """Kirchhoff stress (n, 3, 3) [Pa] of every particle, and the corresponding elastic strain.

    Those that are to have none get none. Raises InputError for a material that cannot carry it.
    """
    scene, population = model.scene, model.population
    tau = np.where(population.unstressed[:, None, None], 0.0, tau)
    for m, law in enumerate(model.laws):
        own = population.material == m
        elastic = law.h_from_stress(tau[own])
        if not np.isfinite(elastic).all():
            name, load = list(scene.materials)[m], np.abs(tau[own]).max()
            raise InputError(f"{scene.source}: materials.{name}: too soft for initial.stress ="
                             f' "{scene.initial.stress}": it cannot carry {load:.3g} Pa')
        population.stress[own] = pack(tau[own], scene.dimension)
        population.elastic[own] = pack(elastic, scene.dimension)


def _load_in_column(scene, positions):
    """Mass per area above each particle of a saw test [kg/m2], and the normal of its slope."""
    load, bottom = np.zeros(len(positions)), 0.0
    for _, layer in scene.saw_test.drawn(scene.solver.dx).layers:
        above = np.clip(bottom + layer.thickness - positions[:, -1], 0.0, layer.thickness)
        load += scene.materials[layer.material].density * above
        bottom += layer.thickness
    return load, np.tile(np.eye(scene.dimension)[-1], (len(positions), 1))
