"""Loads on the driven borders of a specimen."""

import numpy as np


def loads(simulation, obstacle, times):
    """Mean force (dim,) [N] (per metre of width in 2-D) of the matter on an obstacle since the time before, at each of
    `times` [s], to which the simulation is stepped."""
    dim, before, at = simulation.scene.dimension, 0.0, 0.0
    for time in times:
        while simulation.time < time:
            simulation.step(until=time)
        impulse = np.array(simulation.solver.obstacle_totals[obstacle, :dim], float)
        yield (impulse - before) / (simulation.time - at)
        before, at = impulse, simulation.time
