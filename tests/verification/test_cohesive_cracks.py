"""Bars and notched plates that crack (F1; F2 by grips): the work that breaks them is the card's, on every grid.

Bars: `support/drawn_bar.py`. Plates: `support/notched_plate.py`. Blocks that crack twice: `support/crossed_block.py`.
"""

import numpy as np
import pytest

from snowmpm.materials.crack_planes import DAMAGE
from snowmpm.study.problems.schemes import AFLIP
from tests.support import crossed_block, notched_plate
from tests.support.drawn_bar import BAR, draw

GRIDS = (20, 30, 40)
asked = pytest.mark.xfail(strict=True, reason="with grad v of each particle its neighbours crack too: 1.29, 1.26, 1.23")


@pytest.mark.slow
@pytest.mark.parametrize("cells", GRIDS)
@pytest.mark.parametrize("f_bar", ["whole", pytest.param(False, marks=asked)])
def test_a_bar_takes_its_fracture_energy_on_every_grid(cells, f_bar):
    """F1. Asked 2 % of the card; a bar at a point, to 1 %, is in materials/test_cohesive_crack.py."""
    bar = draw(cells, f_bar)
    assert bar.work == pytest.approx(1.0, rel=0.02)
    damage = bar.state[:, DAMAGE]
    assert set(bar.column[damage > 0.0]) == {0.25, 0.75} and damage.max() == 1.0


@pytest.mark.slow
@pytest.mark.parametrize("case", [{"per_axis": 3}, {"scheme": AFLIP}], ids=str)
def test_neither_the_filling_nor_the_transfer_matters(case):
    assert draw(20, **case).work == pytest.approx(1.0, rel=0.02)


AROUND = {
    "drucker_prager": {"kind": "drucker_prager", "friction_angle": 30.0, "cohesion": 1.5e3},
    "cohesive_cam_clay": {"kind": "cohesive_cam_clay", "critical_slope": 1.8, "cohesion": 0.6, "hardening": 5.0,
                          "p0": 5e3},
}
PRESS = 0.01
"""Strain by which a bar is pressed before; both laws yield at about half of it, and not when it is drawn."""


@pytest.mark.slow
@pytest.mark.parametrize("cells", GRIDS)
@pytest.mark.parametrize("around", AROUND)
def test_a_bar_that_yielded_under_pressure_takes_its_fracture_energy(around, cells):
    """As asked of the crack alone: 2 % on every grid. From the reading at which the grips no longer press."""
    law = BAR.model_validate({**BAR.model_dump(), "bulk": AROUND[around]})
    bar = draw(cells, law=law, press=PRESS)
    assert bar.pressed < 0.9 * PRESS * BAR.youngs_modulus  # it did yield
    assert bar.work == pytest.approx(1.0, rel=0.02)
    damage = bar.state[:, DAMAGE]
    assert set(bar.column[damage > 0.0]) == {0.25, 0.75} and damage.max() == 1.0


@pytest.mark.slow
@pytest.mark.parametrize("cells", GRIDS)
def test_a_row_that_cracks_anew_takes_its_energy_each_time(cells):
    """`reset`: two cracks and a part of the third, to 2 %; the row stays the only one that cracks."""
    law = BAR.model_copy(update={"fracture_energy": 0.25, "reset": True})
    bar = draw(cells, law=law, pull=2.5)
    row = np.isin(bar.column, (0.25, 0.75))
    made, damage = bar.state[row, law.first_of_bulk - 1], bar.state[row, DAMAGE]
    assert (made == 2.0).all() and (damage > 0.2).all() and not bar.state[~row, DAMAGE].any()
    expected = 2.0 + (damage * (2.0 - damage)).mean() + bar.stored
    assert bar.work == pytest.approx(expected, rel=0.02)


@pytest.mark.slow
@pytest.mark.parametrize("cells", crossed_block.GRIDS)
def test_a_block_drawn_along_both_axes_takes_the_energy_of_both_cracks(cells):
    """One after the other, each to 2 %; where they cross, particles have both."""
    block = crossed_block.draw(cells)
    np.testing.assert_allclose(block.work, 1.0, rtol=0.02)
    assert block.crossing == 4 and block.astray == 0


PLATES = (0.01, 0.0075, 0.006)


@pytest.mark.slow
@pytest.mark.parametrize("case", ["drawn", "bent"])
def test_a_crack_from_a_notch_takes_its_energy_and_the_curve_is_that_of_every_grid(case):
    """F2 asks for curves within 5 % and G_f within 2 %, of a beam on rollers; here grips draw or bend the plate."""
    broken = [notched_plate.broken(dx, case) for dx in PLATES]
    for plate in broken:
        assert plate.work == pytest.approx(1.0, rel=0.02), plate.dx
        assert set(plate.cracked) == {0.25, 0.75}  # one row of cells, straight from the notch
    finest = broken[-1]
    for plate in broken[:-1]:
        off = np.abs(np.interp(finest.opened, plate.opened, plate.force) - finest.force)
        assert off.max() < 0.05 * finest.force.max(), plate.dx


@pytest.mark.slow
@pytest.mark.xfail(strict=True, reason="without f_bar = whole the neighbours of the crack's row crack too: 1.4 to 1.5")
def test_the_same_without_shared_deformation():
    assert notched_plate.broken(0.01, "drawn", f_bar=False).work == pytest.approx(1.0, rel=0.02)
