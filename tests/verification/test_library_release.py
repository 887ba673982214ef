"""The library's slab release at full resolution: minutes, hence `slow`."""

import numpy as np
import pytest

import snowmpm

CUT = (13.0, 17.0)  # m along x, of a slab from 3 to 24 m


@pytest.mark.slow
def test_crack_runs_through_before_the_slab_has_left():
    """Cut from 1 to 2 s; by 2.2 s the crack is through the whole weak layer under the slab, and the slab slides."""
    simulation = snowmpm.Simulation(snowmpm.load_scene("slab_release_2d"))
    speeds = []
    while simulation.time < 1.0 - 1e-9:
        simulation.step(until=1.0)
        speeds.append(simulation.max_speed)
    assert max(speeds) < 0.01 * np.sqrt(9.81 * 0.5)  # at rest before the cut: 1 % of sqrt(g D)
    while simulation.time < 2.2:
        simulation.step()
    particles = simulation.particles
    weak = particles["material"] == 1
    broken = particles["position"][weak & (particles["damage"] > 0.99), 0]
    assert broken.min() < 4.5 and broken.max() > 22.0  # far beyond the cut at both ends
    assert np.linalg.norm(particles["velocity"][particles["material"] == 0], axis=1).mean() > 0.5
    assert simulation.solver.unconverged == 0
    assert simulation.audit()["momentum_residual"] < 1e-5
