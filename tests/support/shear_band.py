"""A biaxial test of sand that softens: a whole specimen and a quarter of it, by the scenes of the guide."""

from pathlib import Path

import numpy as np

from snowmpm.running.simulation import Simulation
from snowmpm.scenes import load_scene
from tests.support.driven import loads

DOCS = Path(__file__).parents[2] / "docs"
PRESSURE, WIDTH, HEIGHT = 5e3, 0.1, 0.2
RESIDUAL = 2.0 * PRESSURE
"""Deviator [Pa] at 30 degrees, sigma_1 = 3 sigma_3."""
SAMPLES = 80


def scene_of(page):
    return load_scene(str(DOCS / f"{page}.toml"))


class Specimen:
    """A specimen that is shortened: `time` [s], `deviator` [Pa] on the head, a mean over each of `SAMPLES` times, and
    places x (n, 2) [m] and plastic shear of its particles at the end."""

    def __init__(self, page, width):
        scene = scene_of(page)
        simulation = Simulation(scene)
        head = [obstacle.name for obstacle in scene.obstacles].index("head")
        self.time = scene.end_time * np.linspace(0.0, 1.0, SAMPLES + 1)[1:]
        force = np.array([abs(one[1]) for one in loads(simulation, head, self.time)])
        self.deviator = force / width
        fields = simulation.particles
        self.x, self.shear = np.asarray(fields["position"], float), np.asarray(fields["plastic_strain"], float)
        self.audit = simulation.audit()

    @property
    def peak(self):
        return self.deviator.max()

    def softened(self, share):
        """Time from the peak [s] until this share of the strength between peak and residual is lost for good, without
        the swings of the specimen."""
        calm = np.convolve(np.pad(self.deviator, 2, mode="edge"), np.ones(5) / 5.0, "valid")
        above = np.flatnonzero(calm > self.peak - share * (self.peak - RESIDUAL))
        return self.time[above[-1]] - self.time[int(self.deviator.argmax())]
