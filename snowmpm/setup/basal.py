"""Friction of the ground for a method that resolves the depth of the flow."""

import numpy as np

from snowmpm.ground import Coulomb
from snowmpm.ground.states import stresses
from snowmpm.stepping.basal_friction import BasalFriction


def friction_under_particles(model):
    """The coefficient of plain Coulomb friction [-], else the `BasalFriction` of a `Model`. InputError: rasters that do
    not fit."""
    ground = model.friction
    law = ground.law
    if isinstance(law, Coulomb) and not law.rasters and law.tau0 == law.cohesion == 0.0:
        return law.mu
    gravity = float(np.linalg.norm(model.first_gravity))

    def at(plan):
        if ground.varies:
            on_terrain = np.isfinite(model.surface.height(plan))
            numbers = ground.on_nodes(*plan.T, on_terrain=on_terrain, gravity=gravity).T
            return lambda rows, states: stresses(type(law), numbers[rows], states)
        numbers = np.array([law.parameters(gravity)], float)
        return lambda rows, states: stresses(type(law), np.broadcast_to(numbers, (len(rows), numbers.shape[1])), states)

    return BasalFriction(at, model.lower, model.upper, model.scene.solver.dx, model.surface.height, gravity)
