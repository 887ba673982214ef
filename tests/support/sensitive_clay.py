"""The slope of sensitive clay of the guide (`docs/sensitive_clay.toml`), run on a grid."""

from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

from snowmpm.running.simulation import Simulation
from snowmpm.scenes import load_scene

SCENE = Path(__file__).parents[2] / "docs" / "sensitive_clay.toml"
TOE, HEIGHT = 25.0, 5.0
"""Of the slope before it fails [m]."""
TIMES = (5.3, 12.0, 20.0)
"""Of the source's figure 33 [s]."""
GRIDS = (0.5, 0.4, 1.0 / 3.0)
"""Cells [m]: 1.5 from the finest to the coarsest, as the spacings of the source, 8 to 12 cm."""
RUN_OUT = 20.0
"""Of the source [m]."""


@dataclass(frozen=True)
class Moment:
    """The slope at a time [s]: places x (n, 2) [m], plastic strain (n,), highest speed [m/s]."""

    time: float
    x: np.ndarray
    strain: np.ndarray
    speed: float
    dx: float

    @property
    def run_out(self):
        """Way of the tip from the toe [m]: of the foremost particle within a cell of another."""
        near = cKDTree(self.x).query(self.x, k=2)[0][:, 1] < self.dx
        return self.x[near, 0].max() - TOE

    @property
    def of_most(self):
        """Way from the toe within which 99 % of the clay lies [m]."""
        return np.quantile(self.x[:, 0], 0.99) - TOE

    @property
    def scarp(self):
        """Where the surface still lies at its height, farthest from the wall behind [m]."""
        return self.x[self.x[:, 1] > HEIGHT - self.dx, 0].max()


@cache
def slope(dx, **solver):
    """`Moment`s at `TIMES` on cells of dx [m]; solver: keys of the table in place of the scene's."""
    changes = {"solver.dx": dx} | {f"solver.{name}": value for name, value in solver.items()}
    simulation, found = Simulation(load_scene(str(SCENE), changes)), []
    for time in TIMES:
        while simulation.time < time - 1e-9:
            simulation.step(until=time)
        fields = simulation.particles
        speed = np.linalg.norm(np.asarray(fields["velocity"], float), axis=1).max()
        found.append(Moment(time, np.asarray(fields["position"], float),
                            np.asarray(fields["plastic_strain"], float), speed, dx))
    return found
