"""Ground moved by round-off: on a slope of round numbers many nodes lie half a cell above it, where lines begin."""

import numpy as np
import pytest

import snowmpm

SLOPE = [[0.0, 20.0], [26.0, 1.8], [56.0, 1.8]]


def velocities(rise, precision):
    points = [[x, y + rise] for x, y in SLOPE]
    changes = {"solver.dx": 0.5, "solver.precision": precision, "terrain.points": points}
    simulation = snowmpm.Simulation(snowmpm.load_scene("impact_wedge_2d", changes))
    for _ in range(5):
        simulation.step()
    fields = simulation.particles
    return fields["velocity"][np.argsort(fields["id"])]


@pytest.mark.parametrize(("precision", "rises", "most"), [("f64", (3e-14, 1e-12), 1e-10), ("f32", (1e-6,), 1e-4)])
def test_ground_higher_by_round_off_does_not_change_the_flow(precision, rises, most):
    expected = velocities(0.0, "f64")
    for rise in (0.0, *rises):
        found = velocities(rise, precision)
        assert np.abs(found - expected).max() <= most * np.abs(expected).max(), rise
