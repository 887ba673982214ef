"""Peak maps: depth and speed of what stood over a plan cell."""

import numpy as np
import pytest

from snowmpm.errors import InputError
from snowmpm.materials import Elastic
from snowmpm.mpm.solver import MpmSolver
from snowmpm.particles.population import Population
from snowmpm.results.map_grid import MapGrid, grid_for
from snowmpm.results.maps import FLOW_SHARE, GRAINS, KEPT, PeakMaps, cell_for
from snowmpm.study.problems.schemes import lattice


def test_a_block_that_slides_over_the_map():
    """A block of 0.8 x 0.4 x 0.6 m at 2 m/s along x: depth 0.6 m and speed 2 m/s wherever it has been in full."""
    positions, volumes = lattice([1.0, 1.0, 0.2], [1.8, 1.4, 0.8], 0.1)
    velocities = np.broadcast_to([2.0, 0.0, 0.0], positions.shape).copy()
    solver = MpmSolver(Population(positions, volumes, 0, velocities),
                       [Elastic(density=300.0, youngs_modulus=1e5, poisson_ratio=0.3)], dx=0.1, precision="f64",
                       origin=[0.0] * 3, lower=[0.0] * 3, upper=[4.0, 3.0, 2.0], gravity=[0.0] * 3)
    peaks = PeakMaps(solver, MapGrid.over([0.0, 0.0], [4.0, 3.0], 0.2))
    for _ in range(80):
        peaks.see(solver)
        solver.step(0.005)
    values, x0, y0, cell = peaks.rasters()["peak_depth"]
    assert (x0, y0, cell) == pytest.approx((0.1, 0.1, 0.2)) and values.shape == (15, 20)
    assert values[5, 5:12] == pytest.approx(np.full(7, 0.6), rel=1e-6)  # y = 1.1 m, x = 1.1 to 2.3 m
    assert np.isnan(values[8]).all() and np.isnan(values[5, :5]).all() and np.isnan(values[5, 16:]).all()
    speed = peaks.rasters()["peak_speed"][0]
    assert np.nanmax(speed) == pytest.approx(2.0, rel=1e-6)
    pressure = peaks.rasters()["peak_pressure"][0]
    assert np.nanmax(pressure) == pytest.approx(300.0 * 2.0**2, rel=1e-6)  # rho v^2
    assert np.nanmax(peaks.rasters()["peak_momentum"][0]) == pytest.approx(0.6 * 2.0, rel=1e-6)  # level ground: h v
    duration = peaks.rasters()["flow_duration"][0]
    assert duration[5, 5] == pytest.approx(0.0875, abs=0.005)  # its last column, at x = 1.025 m, goes over 1.2 m
    assert duration[5, 9] == pytest.approx(0.395 - 0.0125, abs=0.006)  # until now: 0.395 s
    passed = peaks.rasters()["passed_east"][0]
    assert passed[5, 8] == pytest.approx(0.6 * 0.7, rel=0.03)  # 0.7 m of the block, 0.6 m deep, lay before x = 1.7 m
    assert np.nanmax(np.abs(peaks.rasters()["passed_north"][0])) < 1e-9
    release = peaks.rasters()["release_depth"][0]
    assert np.nansum(release) == pytest.approx(8 * 0.6, rel=1e-6) and np.nansum(release > 0.0) == 8  # 4 x 2 cells
    deposit = peaks.rasters()["deposit_depth"][0]
    assert np.nansum(deposit) == pytest.approx(np.nansum(release), rel=1e-6)
    assert np.nansum(deposit[:, :8]) == 0.0  # it has gone on by 0.79 m
    arrival = peaks.rasters()["arrival_time"][0]
    assert arrival[5, 5] == 0.0 and np.isnan(arrival[8]).all()  # it lay there
    # The first column of particles, at x = 1.775 m, comes over the cell from x = 2.2 m on after 0.2125 s
    assert arrival[5, 11] == pytest.approx(0.2125, abs=0.005) and np.diff(arrival[5, 9:12]) == pytest.approx(0.1)
    moved = PeakMaps(solver, MapGrid.over([1.0, 0.5], [3.0, 2.0], 0.25, [0.1, 0.2]))
    moved.see(solver)
    depth, x0, y0, cell = moved.rasters()["peak_depth"]
    assert np.nansum(depth) * cell**2 == pytest.approx(np.nansum(deposit) * 0.2**2, rel=1e-6)  # the same snow
    left = x0 - 0.5 * cell + cell * np.flatnonzero((depth > 0.0).any(axis=0)).min()
    assert left == pytest.approx(1.6)  # the block now begins at x = 1.79 m; lines at 0.1 + j 0.25 m


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


def test_map_cells_fit_the_raster():
    """Cells of 5 m whose corner lies at 2.5 m: whole multiples, on the raster's own lines, whatever part is read."""
    lattice = (np.array([247002.5, 352001.0]), 5.0)
    for least, cell in ((3.0, 5.0), (5.0, 5.0), (5.1, 10.0), (12.4, 15.0)):
        grid = grid_for([247100.0, 352050.0, 900.0], [247410.0, 352333.0, 1900.0], least, lattice=lattice)
        assert grid.cell == cell
        assert np.allclose((grid.lower - lattice[0]) / 5.0 % 1.0 % 1.0, 0.0, atol=1e-9)
        assert (grid.lower <= [247100.0, 352050.0]).all() and (grid.upper >= [247410.0, 352333.0]).all()
        part = grid_for([247203.0, 352111.0], [247301.0, 352222.0], least, lattice=(lattice[0] + 35.0, 5.0))
        assert np.allclose((part.lower - grid.lower) / cell % 1.0, 0.0, atol=1e-9)


def test_a_wish_for_map_cells_is_kept_or_refused():
    lattice = (np.zeros(2), 5.0)
    for wish in (5.0, 30.0, 2.5, 1.0):
        assert grid_for([0.0, 0.0], [100.0, 50.0], 8.0, wish, lattice).cell == wish
    for wish, words in ((7.0, "5 or 10"), (2.0, "1.66667 or 2.5"), (4.0, "2.5 or 5")):
        with pytest.raises(InputError, match=f"whole multiple of the raster's cells of 5 m.*{words}"):
            grid_for([0.0, 0.0], [100.0, 50.0], 8.0, wish, lattice)
    odd = 4.997678230579  # a raster of 5 m in another projection
    for wish, cells in ((30.0, 6.0), (5.0, 1.0), (2.5, 0.5)):
        assert grid_for([0.0, 0.0], [100.0, 50.0], 3.0, wish, (np.zeros(2), odd)).cell == pytest.approx(cells * odd)
    assert grid_for([0.0, 0.0], [100.0, 50.0], 8.2837).cell == 8.3
    assert grid_for([0.0, 0.0], [100.0, 50.0], 8.2837, 7.0).shape == (15, 8)


def test_thickness_is_normal_to_the_ground():
    """A layer of 2 m normal to a slope has the vertical depth 2 m / cos; over several slopes the mean cosine counts."""
    angle = np.radians(50.0)
    peaks = PeakMaps.__new__(PeakMaps)
    peaks.lower, peaks.cell, peaks.shape = np.zeros(2), 4.0, (3, 2)
    peaks.values = {name: np.zeros((3, 2)) for name in KEPT}
    peaks.values["peak_depth"][:2] = 2.0 / np.cos(angle)
    peaks.values["deposit_depth"][0] = 1.0
    peaks.values["peak_momentum"][0] = 6.0  # of the vertical depth

    def normal(plan):
        """50 degrees west of x = 6 m, flat east of it: the second column of cells is half and half; a hole beyond."""
        steep = plan[:, 0] < 6.0
        up = np.where(steep, np.cos(angle), 1.0)
        return np.where(plan[:, :1] > 8.0, np.nan, np.column_stack([np.sin(angle) * steep, 0.0 * up, up]))

    found = peaks.rasters(normal)
    thickness = found["peak_thickness"][0].T
    assert thickness[0] == pytest.approx(2.0)
    assert thickness[1] == pytest.approx(2.0 / np.cos(angle) * 0.5 * (1.0 + np.cos(angle)))
    assert np.isnan(thickness[2]).all()  # no snow
    assert found["deposit_thickness"][0].T[0] == pytest.approx(np.cos(angle))
    assert found["peak_momentum"][0].T[0] == pytest.approx(6.0 * np.cos(angle))
    assert not {"peak_thickness", "deposit_thickness"} & peaks.rasters().keys()
