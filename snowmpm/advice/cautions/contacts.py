"""Rules: obstacles thinner than the grid or out of reach."""

import numpy as np

from snowmpm.advice.cautions.caution import Caution, beyond, rule, worded
from snowmpm.setup.obstacle_reach import ACROSS, across, doubts, key_of


@rule("mpm")
def thin_obstacle(facts):
    """An obstacle so thin that snow passes through it on this grid."""
    setting = "cubic" if facts.scene.solver.kernel == "cubic" else "between nodes"
    for i, obstacle in enumerate(facts.model.obstacles):
        if across(obstacle) < ACROSS * facts.dx:
            continue  # a mast: snow passes around it anyway
        thickness = 2.0 * float(np.min(obstacle.shape.size)) / facts.dx
        if border := beyond("thin_obstacle", setting, thickness):
            yield worded(border, key_of(facts.model, i), thickness)


@rule("mpm", "sph")
def doubtful_obstacle(facts):
    """An obstacle too slender for the grid, or mostly out of reach of the snow."""
    for doubt in doubts(facts.model):
        yield Caution("", doubt.key, doubt.says, doubt.cure)
