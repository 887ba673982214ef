"""The library's slab releases at full resolution."""

import numpy as np
import pytest

import snowmpm

CUT = (13.0, 17.0)  # m along x, of a slab from 3 to 24 m


@pytest.mark.slow
def test_crack_runs_through_before_the_slab_has_left():
    """Cut from 1 to 2 s; by 2.2 s the crack is through the whole weak layer under the slab, and the slab slides."""
    simulation = snowmpm.Simulation(snowmpm.load_scene("slab_release_2d"))
    simulation.solver.time = 0.0  # the rest before the cut is computed here, and looked at
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


def test_the_slab_above_the_gully_slides():
    """A second after the cut half of the slab is faster than 1 m/s, and the firm snow above it is where it was."""
    simulation = snowmpm.Simulation(snowmpm.load_scene("slab_release"))
    while simulation.time < 1.3 - 1e-9:
        simulation.step(until=1.3)
    particles, names = simulation.particles, [body.name for body in simulation.scene.bodies]
    slab = particles["velocity"][particles["body"] == names.index("slab")]
    assert np.median(np.linalg.norm(slab, axis=1)) > 1.0
    order = np.argsort(particles["id"])
    way = np.linalg.norm(particles["position"][order] - simulation.model.population.positions, axis=1)
    assert np.median(way[particles["body"][order] == names.index("snow_above")]) < 0.1
