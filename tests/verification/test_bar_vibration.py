"""Axial vibration of a bar fixed at one end: the period, and the order at which the wall is resolved.

L = 25 m, E = 100 Pa, rho = 1 kg/m3, nu = 0: T = 4 L / sqrt(E / rho) = 10 s (validation case M4). The wall is second
order on a node; between nodes it is off by a hundredth of a cell. Held nodes act as a wall shifted by a third of a cell
(0.65 % of the period at 50 cells).
"""

import numpy as np
import pytest

from snowmpm.materials import Elastic
from snowmpm.mpm.solver import MpmSolver
from snowmpm.population import Population
from tests.mpm.conftest import lattice

LENGTH, PERIOD = 25.0, 10.0
DECLARED_ORDER = 2.0
SHIFT = 0.01  # cells, between nodes


def period(cells, transfer, offset):
    """Period of the first mode from the zero crossings of the mean velocity over two periods.

    offset: of the wall from a node [cells]."""
    dx = LENGTH / cells
    positions, volumes = lattice([0.0, 0.0], [LENGTH, 3 * dx], dx)
    wall = offset * dx
    velocities = np.zeros_like(positions)
    velocities[:, 0] = 0.1 * np.sin(np.pi * positions[:, 0] / (2 * LENGTH))
    solver = MpmSolver(Population(positions + wall, volumes, 0, velocities),
                       [Elastic(density=1.0, youngs_modulus=100.0, poisson_ratio=0.0)], dx=dx, precision="f64",
                       origin=[0.0, 0.0], lower=[wall, wall], upper=[2 * LENGTH, 3 * dx + wall], gravity=[0.0, 0.0],
                       sides=[["stick", "open"], ["slip", "slip"]], transfer=transfer)
    dt, times, means = 0.2 * dx / 10.0, [], []
    while solver.time < 1.9 * PERIOD:
        solver.step(dt)
        times.append(solver.time)
        means.append(solver.particles.column("velocity")[:, 0].mean())
    times, means = np.array(times), np.array(means)
    k = np.flatnonzero(means[:-1] * means[1:] < 0.0)
    crossings = times[k] - means[k] * (times[k + 1] - times[k]) / (means[k + 1] - means[k])
    return 2.0 * np.diff(crossings).mean()


@pytest.mark.parametrize("transfer", ["apic", "flip"])
def test_period_converges_at_the_declared_order(transfer):
    cells = np.array([12, 25, 50])
    errors = np.abs([period(int(n), transfer, 0.0) / PERIOD - 1.0 for n in cells])
    order = -np.polyfit(np.log(cells), np.log(errors), 1)[0]
    assert abs(order - DECLARED_ORDER) < 0.25
    assert errors[-1] < 4e-4


@pytest.mark.parametrize("transfer, offset", [("apic", 0.3), ("aflip", 0.8)])
def test_a_wall_between_nodes_is_where_it_should_be(transfer, offset):
    error = period(50, transfer, offset) / PERIOD - 1.0
    assert 50 * abs(error) < SHIFT
