"""Axial vibration of a bar fixed at one end: the period, and the order at which the wall is resolved.

L = 25 m, E = 100 Pa, rho = 1 kg/m3, nu = 0: T = 4 L / sqrt(E / rho) = 10 s (validation case M4). The wall is second
order on a node; between nodes it is off by a hundredth of a cell. Held nodes act as a wall shifted by a third of a cell
(0.65 % of the period at 50 cells).
"""

import numpy as np
import pytest

from snowmpm.study.problems.bar_vibration import PERIOD, period
from snowmpm.study.problems.schemes import Scheme

DECLARED_ORDER = 2.0
SHIFT = 0.01  # cells, between nodes


@pytest.mark.parametrize("transfer", ["apic", "flip"])
def test_period_converges_at_the_declared_order(transfer):
    cells = np.array([12, 25, 50])
    errors = np.abs([period(Scheme(transfer), int(n)) / PERIOD - 1.0 for n in cells])
    order = -np.polyfit(np.log(cells), np.log(errors), 1)[0]
    assert abs(order - DECLARED_ORDER) < 0.25
    assert errors[-1] < 4e-4


@pytest.mark.parametrize("transfer, offset", [("apic", 0.3), ("aflip", 0.8)])
def test_a_wall_between_nodes_is_where_it_should_be(transfer, offset):
    error = period(Scheme(transfer), 50, offset) / PERIOD - 1.0
    assert 50 * abs(error) < SHIFT
