"""An elastic column under its own weight at finite strain (M5): settlement and stress, wherever it stands."""

from dataclasses import replace

import numpy as np
import pytest

from snowmpm.study.problems.schemes import APIC, FLIP
from snowmpm.study.problems.self_weight_column import (
    CELLS,
    SNOW,
    SOFT,
    column_errors,
    exact_height,
    settled_errors,
)

CUBIC = replace(APIC, kernel="cubic")


@pytest.mark.parametrize(("scheme", "law"), [(APIC, SNOW), (APIC, SOFT), (CUBIC, SOFT), (FLIP, SOFT)])
def test_settlement_and_stress(scheme, law):
    height, largest, typical = column_errors(law, 10.0, scheme)
    assert height < 0.001  # a tenth of what M5 asks
    assert largest < 0.02 and typical < 0.005


@pytest.mark.parametrize(("law", "offset", "angle"), [
    (SNOW, 1 / 3, None), (SOFT, 1 / 3, None), (SNOW, 0.0, np.pi / 2)])
def test_wherever_the_column_lies_in_the_grid(law, offset, angle):
    height, largest, typical = column_errors(law, 10.0, APIC, offset, angle)
    assert height < 0.002
    assert largest < 0.025 and typical < 0.005  # largest: at the foot of a wall


def test_turned_by_thirty_degrees():
    """12 cells wide. Two errors stay near the walls:

    At an inner corner of walls oblique to the grid. Test functions vanish on a wall in the mean over a cell only: on a
    wall of slope t in the grid, -t dx² / 4 d/dx (dw/dn) is left of w. Along the wall that is nothing; at each of its
    ends it is the work of a force pair p t dx² / 4. The stress is off by two thirds of the pressure at the corner, and
    less with the square of the distance.

    In cells that an oblique wall or face cuts, where few particles stand for a node: 12 % within half a cell, and as
    much at a face that is free (below).

    With functions of force that are corrected for what is left of w at a corner, the gradient of the shape functions
    and 16 particles a cell, the corner is right to 2 % and the settlement to 0.2 %; but then functions of motion and of
    force differ, and at other angles and samplings that gains energy without bound.

    The top feels less of the corners the wider the column (settlement 2.0 % off at 4 cells).
    """
    width = 12
    place, height, off = settled_errors(SNOW, 10.0, APIC, angle=np.pi / 6, width=width)
    assert abs(height[place[:, 1] > 0.95 * CELLS].mean()) < 0.01
    inner = np.minimum(np.minimum(place[:, 0], width - place[:, 0]), place[:, 1]) > 2.0
    assert inner.sum() > 0.6 * len(place)
    assert np.abs(off[inner]).max() < 0.02


@pytest.mark.xfail(strict=True, reason="inner corners of walls oblique to the grid: stress off by half of the pressure "
                                       "at the corner, by 12 % in cells that a wall cuts")
def test_stress_turned_by_thirty_degrees():
    _, largest, _ = column_errors(SNOW, 10.0, APIC, angle=np.pi / 6)
    assert largest < 0.02


def test_free_standing_and_turned_by_thirty_degrees():
    """nu = 0: no walls are needed. 1 m high, so that it does not buckle under its weight: (L / L_c)³ = 12 S (L / w)² /
    7.84 = 0.85, S = rho g L / E. Along the base too, but for its ends and for the cells that the faces cut."""
    width = 12
    place, height, off = settled_errors(SOFT, 1.0, APIC, angle=np.pi / 6, width=width, free=True)
    assert abs(height[place[:, 1] > 0.95 * CELLS].mean()) < 0.01
    x = np.minimum(place[:, 0], width - place[:, 0])
    inner = (x > 2.0) & (np.hypot(x, place[:, 1]) > 3.0)
    assert inner.sum() > 0.6 * len(place) and place[inner, 1].min() < 0.5
    assert np.abs(off[inner]).max() < 0.02


def test_half_its_height():
    """L = 50 m: every particle crosses cells; the base is squeezed to 0.18."""
    height, largest, typical = column_errors(SOFT, 50.0, CUBIC)
    assert exact_height(SOFT, 50.0, 50.0) == pytest.approx(24.2330658728, rel=1e-10)
    assert height < 0.001 and typical < 0.02 and largest < 0.1
