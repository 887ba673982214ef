"""A layer that slips on one band: what softening takes with a length of its own, and without (F6's material)."""

import pytest

from tests.support.softening_layer import LENGTH, sheared

GRIDS = (0.05, 0.1 / 3.0, 0.025)
"""Cells [m], a quarter to an eighth of the length."""
ALIKE = 0.1
"""Difference of the works of softening on the three grids, over that on the finest."""


@pytest.mark.slow
def test_softening_takes_the_work_of_its_length_on_every_grid():
    found = [sheared(dx) for dx in GRIDS]
    works = [one.softened for one in found]
    assert max(works) - min(works) < ALIKE * works[-1]
    assert works[-1] == pytest.approx(1.0, abs=ALIKE)
    for one in found:
        assert one.band == pytest.approx(LENGTH, rel=2 * ALIKE)


@pytest.mark.slow
def test_without_a_length_it_takes_what_the_cells_say():
    works = [sheared(dx, None).softened for dx in GRIDS]
    assert works[0] > 1.6 * works[-1]  # 2 by the cells
    assert works[-1] < 0.5
