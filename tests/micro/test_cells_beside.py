"""Cells of grains at particles of a run: beside the law, and in its place."""

import numpy as np
import pytest

from snowmpm.micro.grains.beside import PLANE, CellPoint, CellsBeside, upper_triangle
from snowmpm.micro.grains.bonded import bonded_cell
from snowmpm.micro.grains.contact import ContactLaw
from snowmpm.micro.grains.curves import driven_path, jump_path
from snowmpm.running.simulation import Simulation
from snowmpm.scenes import load_scene

SNOW = ContactLaw(8e3, 4e3, friction=0.2, strength=2.72e4, shear_strength=2.72e4)
LAW = {"kind": "elastic", "density": 110.0, "youngs_modulus": 9e5, "poisson_ratio": 0.2}
END = 0.016  # s: the wave of the cover has passed the block and come back
PRESSED = {"materials.sample": LAW, "initial": {"stress": "none"}, "solver.precision": "f64",
           "obstacles.0.motion": {"velocity": [0.0, -0.2]}, "end_time": END}


@pytest.fixture(scope="module")
def sample():
    return bonded_cell(60, 5e-4, SNOW, solid=0.38, seed=2, density=290.0)


def turn(angle):
    return np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])


def test_a_deformation_is_a_turn_of_a_triangle():
    F = turn(2.0) @ np.array([[0.9, 0.3], [0.0, 1.2]])
    Q, T = upper_triangle(F)
    np.testing.assert_allclose(Q, turn(2.0), atol=1e-14)
    np.testing.assert_allclose(T, [[0.9, 0.3], [0.0, 1.2]], atol=1e-14)
    with pytest.raises(ValueError, match="must be > 0"):
        upper_triangle(np.diag([1.0, -1.0]))


def test_a_turned_cell_has_the_turned_stress(sample):
    F = np.array([[1.0, 4e-4], [0.0, 1.0 - 1e-3]])
    straight, turned = CellPoint(sample), CellPoint(sample)
    stress = straight.deform(F)[PLANE]
    turned.deform(turn(0.7))
    np.testing.assert_allclose(turned.deform(turn(0.7) @ F)[PLANE], turn(0.7) @ stress @ turn(0.7).T,
                               atol=1e-6 * np.abs(stress).max())


def test_a_cell_follows_as_in_a_test(sample):
    """Within the swings of its grains, whatever the pieces of the path are."""
    curve, point = jump_path(sample, [(-2e-3, 1e-3)], "closing"), CellPoint(sample)
    for share in np.linspace(0.05, 1.0, 20):
        stress = point.deform(np.eye(2) + share * np.array([[0.0, 1e-3], [0.0, -2e-3]]))
    np.testing.assert_allclose(stress, curve.stress[-1], atol=0.02 * np.abs(curve.stress).max())


def pressed(sample, acting):
    """A block that is pressed, with a cell in its middle, and the row of that particle."""
    simulation = Simulation(load_scene("oedometer", PRESSED))
    fields = simulation.particles
    number = int(fields["id"][np.linalg.norm(fields["position"] - [0.25, 0.5], axis=1).argmin()])
    cells = CellsBeside(simulation, sample, [number], acting)
    while simulation.time < END * (1.0 - 1e-9):
        cells.step(END)
    return simulation.particles, cells, int(np.flatnonzero(simulation.particles["id"] == number)[0])


def test_cells_beside_and_in_place_of_a_law(sample):
    """The cell has the stress of the grains' test at its deformation. In the law's place, it bears what the run has
    there; grains that are softer than the law give way more than the law does."""
    closing = {}
    for acting in (False, True):
        fields, cells, row = pressed(sample, acting)
        F, stress, law = cells.deformation[0], cells.stress[0], cells.law[0]
        assert np.linalg.det(F) == pytest.approx(fields["J"][row], rel=1e-6)
        there = np.eye(3)
        there[PLANE] = upper_triangle(F)[1]
        alone = driven_path(sample, [there], "alone").stress[-1]
        np.testing.assert_allclose(stress, alone, atol=0.02 * np.abs(alone).max())
        shown = fields["stress"][row, :3]  # x, z, out of plane
        np.testing.assert_allclose(shown, np.diag(stress if acting else law)[[0, 2, 1]], rtol=1e-5)
        assert abs(stress[2, 2]) < 0.9 * abs(law[2, 2])
        closing[acting] = 1.0 - F[1, 1]
    assert 2e-3 < 1.01 * closing[False] < closing[True] < 1.2 * closing[False]


def test_runs_without_such_particles_are_refused(sample):
    simulation = Simulation(load_scene("oedometer", PRESSED))
    with pytest.raises(ValueError, match="no such particles"):
        CellsBeside(simulation, sample, [10**6])
    with pytest.raises(ValueError, match="MPM in 2-D"):
        CellsBeside(Simulation(load_scene("oedometer", {**PRESSED, "solver.method": "sph"})), sample, [0])
