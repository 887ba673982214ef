"""Rules: bodies and obstacles that the cells do not resolve, and densities that are no snow's."""

import numpy as np

from snowmpm.advice.cautions.caution import Caution, accepted, rounded_down, rule
from snowmpm.advice.cautions.layers import too_shallow
from snowmpm.components import carried
from snowmpm.methods import METHODS

LEAST_CELLS = 2.0
"""Thickness [cells] from which on strain across a body can vary in it: a spline reaches over two cells."""

FITTED = 0.95
"""Share of the extent of a body that its lattice of particles spans at least."""

IN_PLAN = [name for name, entry in METHODS.items() if entry.capabilities.plan]
ON_GRID = [name for name, entry in METHODS.items() if entry.capabilities.grid and not entry.capabilities.plan]


@rule(*ON_GRID)
def thin_body(facts):
    """A body of any shape thinner than LEAST_CELLS that touches no other; layers that may slide have a rule of their
    own (`layers.shallow_flow`)."""
    touching = {body for pair in facts.pairs if pair.distance == 0 for body in (pair.first, pair.second)}
    if facts.begin > 0.0:
        return
    shallow = too_shallow(facts) is not None
    for i, body in enumerate(facts.scene.bodies):
        if i in touching or carried(facts.scene, body) or (shallow and body.shape.kind == "layer"):
            continue
        cells = facts.thickness(i)
        if cells < FITTED * LEAST_CELLS:
            dx = rounded_down(cells * facts.dx / LEAST_CELLS)
            whole = facts.extent(i) + 1.0 / facts.per_axis < 1.0 + 1e-6
            within = "it is smaller than a cell" if whole else "strain across it is one number"
            cure = f"solver.dx = {dx:g} or less" if accepted(facts, {"solver.dx": dx}) else "a finer grid"
            yield Caution("", f"bodies.{i} ({body.name})", f"{cells:.2g} cells thick: {within}", cure)


LIGHTEST = 20.0
"""Density [kg/m3] below which a material is doubted: fresh snow has 30 and more."""


@rule(*IN_PLAN)
def small_gauge(facts):
    """A gauge less than LEAST_CELLS wide: depth and speed are means over cells that reach far beyond it (obstacles in
    space have a rule of their own, `contacts`)."""
    for i, obstacle in enumerate(facts.model.obstacles):
        lower, upper = obstacle.bounds_at(0.0)
        # A thin wall is met on its broad side
        width = float(np.max((upper - lower)[:2]))
        if width < FITTED * LEAST_CELLS * facts.dx and facts.begin == 0.0:
            dx = rounded_down(width / LEAST_CELLS)
            cure = f"solver.dx = {dx:g} or less" if accepted(facts, {"solver.dx": dx}) else "a finer grid"
            yield Caution("", f"obstacles.{i} ({obstacle.name})", f"{width:.3g} m wide, {width / facts.dx:.2g} cells:"
                          " the load on it depends on the grid", cure)


@rule(*METHODS)
def light_material(facts):
    """A density that is lighter than snow by far, as one in g/cm3 is."""
    used = {body.material for body in facts.scene.bodies}
    for name, material in facts.scene.materials.items():
        density = material.get("density")
        if name in used and facts.begin == 0.0 and density is not None and density < LIGHTEST:
            yield Caution("", f"materials.{name}.density", f"{density:g} kg/m3 is lighter than any snow on the ground",
                          "densities are in kg/m3: snow has 30 to 600")
