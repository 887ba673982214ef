"""Peak maps: depth and speed of what stood over a plan cell."""

import numpy as np
import pytest

from snowmpm.maps import FLOW_SHARE, GRAINS, PeakMaps, cell_for
from snowmpm.materials import Elastic
from snowmpm.mpm.solver import MpmSolver
from snowmpm.population import Population
from tests.mpm.conftest import lattice


def test_a_block_that_slides_over_the_map():
    """A block of 0.8 x 0.4 x 0.6 m at 2 m/s along x: depth 0.6 m and speed 2 m/s wherever it has been in full."""
    positions, volumes = lattice([1.0, 1.0, 0.2], [1.8, 1.4, 0.8], 0.1)
    velocities = np.broadcast_to([2.0, 0.0, 0.0], positions.shape).copy()
    solver = MpmSolver(Population(positions, volumes, 0, velocities),
                       [Elastic(density=300.0, youngs_modulus=1e5, poisson_ratio=0.3)], dx=0.1, precision="f64",
                       origin=[0.0] * 3, lower=[0.0] * 3, upper=[4.0, 3.0, 2.0], gravity=[0.0] * 3)
    peaks = PeakMaps(solver, 0.2)
    for _ in range(80):
        peaks.see()
        solver.step(0.005)
    values, x0, y0, cell = peaks.rasters()["peak_depth"]
    assert (x0, y0, cell) == pytest.approx((0.1, 0.1, 0.2)) and values.shape == (15, 20)
    assert values[5, 5:12] == pytest.approx(np.full(7, 0.6), rel=1e-6)  # y = 1.1 m, x = 1.1 to 2.3 m
    assert np.isnan(values[8]).all() and np.isnan(values[5, :5]).all() and np.isnan(values[5, 16:]).all()
    speed = peaks.rasters()["peak_speed"][0]
    assert np.nanmax(speed) == pytest.approx(2.0, rel=1e-6)
    pressure = peaks.rasters()["peak_pressure"][0]
    assert np.nanmax(pressure) == pytest.approx(300.0 * 2.0**2, rel=1e-6)  # rho v^2
    release = peaks.rasters()["release_depth"][0]
    assert np.nansum(release) == pytest.approx(8 * 0.6, rel=1e-6) and np.nansum(release > 0.0) == 8  # 4 x 2 cells
    deposit = peaks.rasters()["deposit_depth"][0]
    assert np.nansum(deposit) == pytest.approx(np.nansum(release), rel=1e-6)
    assert np.nansum(deposit[:, :8]) == 0.0  # it has gone on by 0.79 m


def layer(depth, dx, side=200.0):
    """A release of `depth` [m] on a square, two particles a cell and axis: positions (n, 3), volumes (n,)."""
    spacing = 0.5 * dx
    x = (np.arange(round(side / spacing)) + 0.5) * spacing
    z = (np.arange(max(1, round(depth / spacing))) + 0.5) * spacing
    positions = np.stack(np.meshgrid(x, x, z, indexing="ij"), axis=-1).reshape(-1, 3)
    return positions, np.full(len(positions), depth * side**2 / len(positions))


def test_cells_hold_enough_particles():
    for depth, dx in ((2.4, 4.8), (2.4, 2.4), (6.0, 2.0)):
        positions, volumes = layer(depth, dx)
        cell = cell_for(positions, volumes, dx)
        assert cell >= 2.0 * dx and FLOW_SHARE * depth * cell**2 / volumes[0] >= 0.99 * GRAINS
    assert cell_for(*layer(6.0, 0.5, side=20.0), 0.5) == 1.0  # deep: as fine as the grid has it
    assert cell_for(np.zeros((0, 3)), np.zeros(0), 0.5) == 1.0


def test_loose_grains_are_no_flow():
    """A sheet of grains half as deep as what counts as flow, seen twenty times: in cells of two spacings eight in
    ten count as affected once; in cells that hold enough, one in fifty, on either grid."""
    random, release = np.random.default_rng(3), 2.4
    share = {}
    for dx in (4.8, 2.4):
        positions, volumes = layer(release, dx)
        for name, cell in (("narrow", 2.0 * dx), ("chosen", cell_for(positions, volumes, dx))):
            expected = 0.5 * FLOW_SHARE * release * cell**2 / volumes[0]
            most = random.poisson(expected, (20, 5000)).max(axis=0)
            share[name, dx] = (most * volumes[0] / cell**2 >= FLOW_SHARE * release).mean()
    assert share["narrow", 4.8] > 0.9 and share["narrow", 2.4] > 0.7
    assert share["chosen", 4.8] < 0.03 and share["chosen", 2.4] < 0.03
