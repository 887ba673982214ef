"""Friction of the ground for a method that resolves the depth of the flow."""

from snowmpm.ground import Coulomb
from snowmpm.stepping.basal_friction import BasalFriction, OverGround


def friction_under_particles(model):
    """The coefficient of plain Coulomb friction [-], else the `BasalFriction` of a `Model`. InputError: rasters that do
    not fit."""
    law = model.friction.law
    if isinstance(law, Coulomb) and not law.rasters and law.tau0 == law.cohesion == 0.0:
        return law.mu
    over = OverGround(model.lower, model.upper, model.scene.solver.dx, model.surface.height, model.first_gravity)
    return BasalFriction(lambda plan: model.friction.stress_at(plan, model.surface, over.gravity), over,
                         model.scene.solver.dx)
