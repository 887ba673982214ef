"""An elastic column under its own weight at finite strain (M5): settlement and stress, wherever it stands."""

from dataclasses import replace

import numpy as np
import pytest

from snowmpm.study.problems.particle_states import ParticleStates
from snowmpm.study.problems.schemes import APIC, FLIP
from snowmpm.study.problems.self_weight_column import SNOW, SOFT, column, column_errors, exact_height, settle

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


def test_settlement_turned_by_thirty_degrees():
    """Of the top of a column 12 cells wide. At an inner corner of oblique walls the test functions, which vanish on a
    wall in the mean over a cell only, are cut: an error of the force there, of which the top feels less the wider the
    column (2.0 % at 4 cells)."""
    length = 10.0
    solver, base, axes = column(SNOW, length, APIC, 0.0, np.pi / 6, width=12)
    states = ParticleStates(solver)
    Y = ((states.reference - base) @ axes.T)[:, 1]
    settle(solver, SNOW, length)
    top = 0.95 * length < Y
    missed = (((states.positions() - base) @ axes.T)[:, 1] - exact_height(SNOW, length, Y))[top].mean()
    assert abs(missed) < 0.01 * (length - exact_height(SNOW, length, length))


@pytest.mark.xfail(strict=True, reason="inner corners of walls oblique to the grid: stress off by half of the pressure")
def test_stress_turned_by_thirty_degrees():
    _, largest, _ = column_errors(SNOW, 10.0, APIC, angle=np.pi / 6)
    assert largest < 0.02


def test_half_its_height():
    """L = 50 m: every particle crosses cells; the base is squeezed to 0.18."""
    height, largest, typical = column_errors(SOFT, 50.0, CUBIC)
    assert exact_height(SOFT, 50.0, 50.0) == pytest.approx(24.2330658728, rel=1e-10)
    assert height < 0.001 and typical < 0.02 and largest < 0.1
