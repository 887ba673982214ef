"""From a scene with a zone to its method: that of the columns around that of the zone."""

from dataclasses import replace

import numpy as np

from snowmpm.errors import InputError
from snowmpm.handover.border import REACH, SPREAD, Border
from snowmpm.handover.moment import inside
from snowmpm.handover.nested import Nested
from snowmpm.particles.population import Population
from snowmpm.scenes.numerics import Sides
from snowmpm.scenes.zone import within
from snowmpm.seeding.regions import regions_of

ROOM = SPREAD + REACH
"""Cells of the columns by which the grid of the particles reaches beyond the region."""


def nested(model, population=None):
    """`Nested` solver of a `setup.model.Model` whose scene has a zone. InputError for a region that cannot be."""
    scene = model.scene
    regions = regions_of(scene.zone.region, model.surface, scene.base_dir, "zone.region")
    border = Border(lambda plan: inside(regions, plan), model.lower, model.upper, scene.solver.dx)
    if not border:
        raise InputError(f"{scene.source}: zone.region: holds the middle of no cell of the columns (solver.dx ="
                         f" {scene.solver.dx:g} m) in the domain")
    here = [_stands_inside(scene, i, obstacle, border) for i, obstacle in enumerate(model.obstacles)]
    outer = replace(model, scene=scene.model_copy(update={"zone": None}),
                    obstacles=[one for one, own in zip(model.obstacles, here, strict=True) if not own])
    inner = zone_of(model, border, [one for one, own in zip(model.obstacles, here, strict=True) if own])
    return Nested(outer.solver(population), inner.solver(), model, inner, border)


def zone_of(model, border, obstacles):
    """`Model` of the zone of a scene: no particles yet, and a domain around the region."""
    scene = within(model.scene)
    if not isinstance(scene.terrain.friction, int | float):  # that for the volume of the release
        terrain = scene.terrain.model_copy(update={"friction": model.friction.law})
        scene = scene.model_copy(update={"terrain": terrain})
    box = border.box(ROOM)
    lower, upper = model.lower.copy(), model.upper.copy()
    lower[:2], upper[:2] = np.maximum(lower[:2], box[0]), np.minimum(upper[:2], box[1])
    scene = scene.model_copy(update={"domain": _open_within(scene.domain, model, lower, upper)})
    most = int(model.population.volumes.sum() / scene.solver.spacing(3) ** 3)
    return replace(model, scene=scene, lower=lower, upper=upper, obstacles=obstacles, expected=most,
                    population=Population(np.zeros((0, 3)), np.zeros(0), 0))


def _open_within(domain, model, lower, upper):
    """The domain of a zone: its sides are open, but for those that it shares with that of the scene."""
    if domain is None:
        return None
    sides = dict(domain.sides(3))
    for axis, name in enumerate("xy"):
        if lower[axis] > model.lower[axis]:
            sides[f"{name}_min"] = "open"
        if upper[axis] < model.upper[axis]:
            sides[f"{name}_max"] = "open"
    return domain.model_copy(update={"boundary": Sides.model_construct(**sides)})


def _stands_inside(scene, i, obstacle, border):
    """Whether an obstacle stands in the zone. InputError for one that stands on its border."""
    plan = np.asarray(obstacle.shape.drawing()[0])[:, :2]
    found = border.entered(plan)
    if found.any() and not found.all():
        raise InputError(f"{scene.source}: obstacles.{i} ({obstacle.name}): stands on the border of zone.region, which"
                         " must hold all of an obstacle or nothing of it")
    return bool(found.any())
