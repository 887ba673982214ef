"""Entry: too long between two exchanges of flow and cloud."""

import functools

import numpy as np

from snowmpm.components.powder_layer.arrays import Below
from snowmpm.components.powder_layer.cloud import EXCHANGE, PowderCloud
from snowmpm.components.powder_layer.declare import PowderLayer
from snowmpm.depth.plan_grid import MARGIN, PlanGrid
from snowmpm.study.atlas.entry import Entry

G, DEPTH, DENSITY, SPEED = 9.81, 1.0, 200.0, 20.0
"""Gravity [m/s2], and a flow that covers all of a level ground: depth [m], density [kg/m3], speed [m/s]."""
TIME, SHORTEST = 4.0, 2.5e-3
"""How long it gives snow to the cloud, and the step of the reference [s]."""


def ice_of_long_steps(dt, longest=EXCHANGE):
    """Ice in the cloud, over that of steps of `SHORTEST`, less 1; dt: step of the flow [s]; longest: part of it between
    two exchanges [s]."""
    return _ice(dt, longest) / _ice(SHORTEST, longest) - 1.0


@functools.cache
def _ice(dt, longest):
    around = ("periodic", "periodic")
    grid = PlanGrid((0.0, 0.0), np.array([20.0, 20.0]), 5.0, (True, True))
    shape = tuple(int(n) + 2 * MARGIN for n in grid.shape)
    ground, flow = np.zeros((*shape, 6)), np.zeros((*shape, 3))
    ground[..., 5] = 1.0
    flow[...] = DEPTH, SPEED, 0.0
    cloud = PowderCloud(Below(flow, ground, np.zeros(shape), DENSITY), grid, (around, around),
                        np.zeros(tuple(grid.shape), bool), G, PowderLayer())
    cloud.longest = longest
    for _ in range(round(TIME / dt)):
        cloud.advance(TIME / round(TIME / dt))
    return cloud.ice_mass


ENTRIES = (
    Entry(
        name="dusty_step", title="Too long between two exchanges of flow and cloud",
        scene="A flow 1 m deep that slides at 20 m/s over level ground gives snow to a powder layer for 4 s",
        seen="The cloud holds more ice, the longer the steps: what goes into it falls out a step later",
        cure="an exchange every 0.05 s, as the program has it", parameter="step of the flow", unit="s",
        values=(0.02, 0.04, 0.08, 0.16, 0.32),
        settings={"once a step": {"longest": 1.0}, "usual": {}},
        symptom="error of the ice in the cloud", limit=0.1, measure=ice_of_long_steps, shown="once a step",
        cured="usual", resolution=0.1),
)

ATLAS = {"depth-averaged flow": ENTRIES}
