"""One particle slides down a frictionless quarter of a circle (M23): at the bottom v = sqrt(2 g h), h = 1 m.

It starts on the surface and sinks in by 0.4 cells, since a single particle is not a half-space of snow: hence the small
cells, which also serve the curvature of the bowl. Exactness of the distance to meshes: tests/terrain.
"""

import numpy as np
import pytest

from snowmpm.materials import Elastic
from snowmpm.mpm.solver import MpmSolver
from snowmpm.particles.population import Population
from snowmpm.study.problems.schemes import AFLIP, APIC

G = 9.81
LAW = Elastic(density=100.0, youngs_modulus=1e3, poisson_ratio=0.3)


class Bowl:
    """Terrain outside a circle of radius 1 m around (0, 1)."""

    def query(self, points):
        inwards = np.array([0.0, 1.0]) - points
        distance = np.linalg.norm(inwards, axis=1)
        return 1.0 - distance, inwards / np.maximum(distance, 1e-12)[:, None]


@pytest.mark.parametrize("contact", ["slip", "separate"])
@pytest.mark.parametrize("scheme", [APIC, AFLIP], ids=str)
def test_speed_at_the_bottom(scheme, contact):
    dx = 0.002
    solver = MpmSolver(Population(np.array([[-1.0, 1.0]]), np.array([0.25 * dx**2]), 0), [LAW], dx=dx, precision="f64",
                       origin=np.array([-2.0, -1.0]), lower=np.array([-2.0, -1.0]), upper=np.array([2.0, 3.0]),
                       gravity=np.array([0.0, -G]), terrain=Bowl(), terrain_contact=contact, **scheme.options)
    while solver.particles.positions()[0, 0] < 0.0 and solver.time < 2.0:
        solver.step(solver.stable_dt()[0])
    assert np.linalg.norm(solver.particles.column("velocity")[0]) == pytest.approx(np.sqrt(2.0 * G), rel=1e-3)
    assert abs(np.linalg.norm(solver.particles.positions()[0] - [0.0, 1.0]) - 1.0) < 0.5 * dx
