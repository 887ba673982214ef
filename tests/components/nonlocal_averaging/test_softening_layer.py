"""A layer that slips on one band: what softening takes with a length of its own, and without (F6's material)."""


import pytest

from snowmpm.components.nonlocal_averaging.layer import LENGTH, Layer, sheared
from snowmpm.study.problems.schemes import Scheme

GRIDS = (0.05, 0.1 / 3.0, 0.025)
"""Cells, of SPH spacings [m], a quarter to an eighth of the length."""
ALIKE = 0.1
"""Difference of the works of softening on the three grids, over that on the finest."""
SPH = Scheme("", method="sph")


def take_the_work_of_their_length(found):
    works = [one.softened for one in found]
    print([f"{one.softened:.3f}, {100.0 * one.band:.1f} cm" for one in found])
    assert max(works) - min(works) < ALIKE * works[-1]
    assert works[-1] == pytest.approx(1.0, abs=ALIKE)
    for one in found:
        assert one.band == pytest.approx(LENGTH, rel=2 * ALIKE)


@pytest.mark.slow
def test_softening_takes_the_work_of_its_length_on_every_grid():
    take_the_work_of_their_length([sheared(Layer(dx)) for dx in GRIDS])


@pytest.mark.slow
def test_softening_by_sph_takes_the_work_of_its_length_at_every_spacing():
    take_the_work_of_their_length([sheared(Layer(dx, scheme=SPH)) for dx in GRIDS])


@pytest.mark.slow
@pytest.mark.parametrize("scheme", [Layer.scheme, SPH], ids=str)
def test_without_a_length_it_takes_what_the_cells_say(scheme):
    works = [sheared(Layer(dx, None, scheme)).softened for dx in GRIDS]
    print([f"{work:.3f}" for work in works])
    assert works[0] > 1.6 * works[-1]  # 2 by the cells
    assert works[-1] < 0.5
