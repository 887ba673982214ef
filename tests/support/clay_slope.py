"""The slope of sensitive clay of the guide, `docs/clay_slope.toml`, on a grid of one's choice."""

from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np

from snowmpm.running.simulation import Simulation
from snowmpm.scenes import load_scene

DOCS = Path(__file__).parents[2] / "docs"
TOE = 25.0  # m
PUBLISHED = 20.0
"""Run-out beyond the toe [m]."""
TIMES = (5.3, 12.0, 20.0)
"""Of the published pictures [s]."""
LAST = 0.005
"""Share of the mass that lies beyond the front."""


class Slid(NamedTuple):
    """The clay at each of TIMES: places (n, 2) [m], plastic strain (n,), front beyond the toe [m]."""

    x: list
    strain: list
    front: list


@cache
def slid(dx, times=TIMES, **changes):
    """`Slid` slope on cells of dx [m]; changes: of the scene, with _ for the dots of keys."""
    keys = {name.replace("__", "."): value for name, value in changes.items()}
    simulation = Simulation(load_scene(str(DOCS / "clay_slope.toml"), {"solver.dx": dx, **keys}))
    found = Slid([], [], [])
    for time in times:
        while simulation.time < time:
            simulation.step(until=time)
        fields = simulation.particles
        x = np.asarray(fields["position"], float)
        found.x.append(x)
        found.strain.append(np.asarray(fields["plastic_strain"], float))
        # Particles have one mass
        found.front.append(float(np.quantile(x[:, 0], 1.0 - LAST) - TOE))
    return found
