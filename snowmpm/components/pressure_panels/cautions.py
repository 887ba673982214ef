"""Rules: panels that the grid cannot tell apart, means over too few steps, and a push that nothing gives."""

import numpy as np

from snowmpm.advice.cautions.caution import Caution, rule
from snowmpm.components.pressure_panels.declare import interval_of

FEW = 5
"""Steps of a mean."""


@rule("mpm")
def small_panels(facts):
    """Panels smaller than the cell that a push is spread over."""
    for key, obstacle in _with_panels(facts):
        if obstacle.panels.size < facts.dx * (1.0 - 1e-9):
            says = f"panels of {obstacle.panels.size / facts.dx:.2g} cells: a push on a node is spread over a cell"
            yield Caution("", f"{key}.size", says, f"size = {facts.dx:g} or more")


@rule("mpm")
def short_means(facts):
    """Means over so few steps that they show the grid rather than the snow."""
    for key, obstacle in _with_panels(facts):
        dt = facts.end / facts.steps
        interval, least = interval_of(facts.scene, obstacle.panels), FEW * dt
        if interval < least * (1.0 - 1e-9):
            says = f"means over {interval:.2g} s, {interval / dt:.2g} steps: peaks of single steps are noise"
            yield Caution("", f"{key}.interval", says, f"interval = {least:.2g} or more")


@rule("mpm")
def against_the_flow(facts):
    """A direction against that in which the snow moves, or would by its weight."""
    model = facts.model
    moving = model.population.volumes @ model.population.velocities
    down = np.append(model.direction, 0.0) if facts.scene.terrain else np.asarray(model.first_gravity, float)
    flow = moving if np.linalg.norm(moving) > 0.0 else down
    for key, obstacle in _with_panels(facts):
        direction = np.asarray(obstacle.panels.direction, float)
        if flow @ direction < -0.1 * np.linalg.norm(flow) * np.linalg.norm(direction):
            says = "the snow moves against it: pushes along it are those of snow that comes back"
            yield Caution("", f"{key}.direction", says, "the direction of the flow, into the obstacle")


def _with_panels(facts):
    for i, obstacle in enumerate(facts.scene.obstacles):
        if obstacle.panels:
            yield f"obstacles.{i}.panels", obstacle
