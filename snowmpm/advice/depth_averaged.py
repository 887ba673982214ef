"""Whether a scene in three dimensions could be depth-averaged, and where a depth-averaged flow is not shallow."""

import numpy as np

from snowmpm import components
from snowmpm.errors import InputError
from snowmpm.methods import METHODS
from snowmpm.scenes.loader import with_overrides
from snowmpm.setup.build import build
from snowmpm.setup.refusals import refuse_beyond

THIN = 0.05
"""Depth of the release over its least extent in plan, below which a flow counts as thin."""
CELL_DEPTHS = 2.5
"""Cells of a depth-averaged scene, in depths of the release: they need not resolve the depth."""
PLAN = next(name for name, entry in METHODS.items() if entry.capabilities.plan)
"""Name of the method of columns in plan."""


def thin(facts):
    """Whether a scene is a release of snow, in layers on a terrain, much wider than deep."""
    scene, terrain = facts.scene, facts.scene.terrain
    if facts.dim != 3 or terrain is None or terrain.kind not in ("dem", "mesh") or scene.solver.in_plan:
        return False
    others = scene.obstacles or scene.events or scene.forces or any(
        component.solid for component in components.used(scene))
    if others or any(body.shape.kind != "layer" for body in scene.bodies):
        return False
    extent = np.ptp(facts.model.population.positions[:, :2], axis=0).min()
    return bool(facts.model.depth < THIN * extent)


def in_columns(facts):
    """Overrides that make a thin scene depth-averaged, with its facts; None where it cannot be."""
    from snowmpm.advice.facts import SceneFacts

    if not thin(facts):
        return None
    dx = max(facts.dx, float(f"{CELL_DEPTHS * facts.model.depth:.1g}"))
    lattice = facts.model.surface.lattice
    if lattice is not None:  # the raster knows no more than its cells do
        dx = float(f"{max(1, round(dx / lattice[1])) * lattice[1]:.6g}")
    overrides = {"solver.method": PLAN, "solver.dx": dx}
    if "particles_per_cell" in facts.scene.solver.model_fields_set:
        overrides["solver.particles_per_cell"] = METHODS[PLAN].capabilities.usual_filling
    try:
        scene = with_overrides(facts.scene, overrides)
        refuse_beyond(scene)
        model = build(scene)
        return overrides, SceneFacts(scene, model, model.solver())
    except InputError:
        return None
