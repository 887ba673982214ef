"""X1 (BM-1): a column of grains against a flexible wall, one body that sticks or parts that may leave each other."""

import numpy as np
import pytest

from snowmpm import Simulation
from tests.components.structures.column_against_wall import measure, scene

pytestmark = pytest.mark.slow
GRID = 0.005
NOT_SO = {
    "first_peak": "7.8 for 9.4 mm: the affine gradient bends the wall of one body too far, where the published one is"
                  " too stiff (test_a_wall_that_its_interpolation_stiffens)",
    "half_range": "1.9 for 2.4 mm, likewise", "period": "133 for 134 ms"}
STIFF = {"precision": "f64", "particles_per_cell": 4, "gradient": "shape", "transfer": "flip", "flip_ratio": 0.97}
"""Strain from the interpolation at the particles, as of a finite element, in place of the affine velocity field."""


@pytest.fixture(scope="module")
def couplings():
    return {name: measure(GRID, name == "one body")[2] for name in ("one body", "parts")}


@pytest.fixture(scope="module")
def finer():
    return {name: measure(0.5 * GRID, name == "one body", until=0.52)[2] for name in ("one body", "parts")}


def test_the_peak_tends_to_eight_millimetres(couplings, finer):
    """With one body from above, with parts from below: the note's 8 mm within 15 %, and nearer on the finer grid."""
    for name in ("one body", "parts"):
        coarse, fine = (abs(found[name]["first_peak"] - 0.008) for found in (couplings, finer))
        assert fine < coarse < 0.0015 and fine < 0.0012


# A run that fails is an error, and not one of the differences that are missed
MISSED = [pytest.param(what, True, marks=pytest.mark.xfail(strict=True, raises=AssertionError, reason=why))
          for what, why in NOT_SO.items()]


@pytest.mark.parametrize(("what", "larger"), [("late", False), ("gap", False), *MISSED])
def test_what_parting_changes(couplings, what, larger):
    """Directions of the differences between the couplings: the published ones."""
    one, parts = (couplings[name][what] for name in ("one body", "parts"))
    assert (parts > one) == larger and parts != one


@pytest.fixture(scope="module")
def finest():
    return {name: measure(0.4 * GRID, name == "one body", until=0.52)[2] for name in ("one body", "parts")}


def test_on_the_third_grid(couplings, finer, finest):
    """T2, cells of 5, 2.5 and 2 mm: still within 15 % of 8 mm. In parts the peak hardly moves; of one body it falls."""
    for name in ("one body", "parts"):
        assert finest[name]["first_peak"] == pytest.approx(0.008, rel=0.15)
    peaks = {name: [found[name]["first_peak"] for found in (couplings, finer, finest)] for name in finest}
    assert np.ptp(peaks["parts"]) < 0.03 * 0.008
    assert peaks["one body"] == sorted(peaks["one body"], reverse=True)


@pytest.mark.xfail(strict=True, raises=AssertionError, reason="1.3e5: the wall that leans bears 3.7 times the moment")
def test_a_stiff_wall_moves_by_the_ratio_of_moduli(couplings):
    """T3: walls of 1 MPa and 30 GPa, in parts. Under one load the tips would move as 3e4 to 1; over their moments at
    the foot they do as 3.6e4 to 1 in the mean after 0.8 s, when the stiff wall still swings."""
    stiff = measure(GRID, False, modulus=3e10)[2]
    assert couplings["parts"]["late"] / stiff["late"] == pytest.approx(3e4, rel=0.2)


@pytest.mark.xfail(strict=True, raises=AssertionError, reason="3.20 for 3.23 kg/m; on 5 mm 3.28 for 3.26")
def test_more_grains_are_set_in_motion_where_they_may_part(finer):
    assert finer["parts"]["upper_left"] > 1.005 * finer["one body"]["upper_left"]


def test_a_wall_that_its_interpolation_stiffens(couplings):
    """Why two of the published differences are missed: they are those of a wall of one body that is too stiff.

    With the gradient of the shape functions the wall of one body bends as the published one: the less, the coarser the
    grid. Beside it the parts have the published higher peak and wider swing.
    """
    one, finer = (measure(dx, True, until, solver={"dx": dx, **STIFF})[2]
                  for dx, until in ((GRID, 1.0), (0.5 * GRID, 0.52)))
    assert one["first_peak"] < 0.8 * finer["first_peak"] < 0.8 * 0.008
    for what in ("first_peak", "half_range"):
        assert couplings["parts"][what] > 1.2 * one[what]


def test_it_settles_and_its_momentum_is_accounted_for(couplings):
    assert couplings["parts"]["unsettled"] == 0
    simulation = Simulation(scene(GRID, False))
    while simulation.time < 0.25:
        simulation.step()
    row = simulation.audit()
    assert row["structure_momentum_residual"] < 1e-9 and row["momentum_residual"] < 1e-10
    assert row["structure_rounds"] / row["steps"] < 6.0 and np.isfinite(row["wall_foot_moment"])
