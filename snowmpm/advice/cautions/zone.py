"""Rule: a region in three dimensions whose border lies too near to what stands in it."""

import numpy as np

from snowmpm.advice.cautions.caution import Caution, rule
from snowmpm.methods import METHODS

ROOM = 6.0
"""Cells of the columns from the border of a zone to an obstacle in it: three, over which columns that enter are spread,
and as many again in which the flow is one of particles only."""

ROUNDS = 64
"""Places around an obstacle at which the region is looked for."""


@rule(*[name for name, entry in METHODS.items() if entry.capabilities.plan])
def near_the_border(facts):
    """An obstacle in a zone with less than `ROOM` cells of it on some side, within the domain."""
    if not facts.scene.zone:
        return
    border, way = facts.solver.border, ROOM * facts.dx
    for i, obstacle in enumerate(facts.model.obstacles):
        plan = np.asarray(obstacle.shape.drawing()[0])[:, :2]
        if not border.entered(plan).all():
            continue
        angle = np.linspace(0.0, 2.0 * np.pi, ROUNDS, endpoint=False)
        ring = way * np.column_stack([np.cos(angle), np.sin(angle)])
        around = (plan[:, None] + ring).reshape(-1, 2)
        around = around[((around >= facts.model.lower[:2]) & (around < facts.model.upper[:2])).all(axis=1)]
        if not border.entered(around).all():
            yield Caution("", "zone.region", f"ends less than {ROOM:g} cells of columns ({way:g} m) from"
                          f" obstacles.{i} ({obstacle.name}): on the side that the snow comes from, what it does there"
                          " is not resolved", "a larger region, or a smaller solver.dx")
