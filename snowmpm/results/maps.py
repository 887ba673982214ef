"""Peak values in plan over a run, and what lies where in the end: what hazard mapping works with.

A depth in a plan cell is a number of particles, n = depth x area / volume of one, that scatters by sqrt(n), and a peak
over time takes the largest of many such counts. Where a cell holds two particles at the depth that counts as flow,
loose grains of a sheet half as deep make it affected; where it holds `GRAINS`, they rarely do. In cells too small for
its particles, the area that a flow covers is a matter of their size.

How much, the frames of two real avalanches say (73 000 to 147 000 particles; tests/test_avalanche_on_terrain.py), of
which every second, fourth or eighth particle was counted for as many: the same flow, drawn of fewer. Particles in a
cell at the flow depth, cells of 20 to 50 m, and how much larger the affected area was than that of all particles:

    6: 19 %     11 to 14: 5 to 11 %     21 to 29: 2 to 7 %     40 to 57: 1 to 4 %     from 80 on: 1 %
"""

import numpy as np

from snowmpm.errors import InputError
from snowmpm.quantities.table import RASTERS, units_of

UNITS = units_of(RASTERS)
"""Unit of each raster."""

FLOW_SHARE = 0.1
"""Share of the mean release depth below which what lies over a plan cell are scattered grains and no flow: their speed
is not that of the avalanche."""

GRAINS = 24
"""Particles in a plan cell at the flow depth: their scatter adds 2 to 7 per cent to what is affected."""

LEAST_CELLS = 2.0
"""Least side of a plan cell in grid spacings: no map is finer than what it is drawn of."""


def cell_for(positions, volumes, dx):
    """Side [m] of plan cells that hold `GRAINS` particles at the flow depth, and are `LEAST_CELLS` wide or more.

    positions (n, 3) [m] and volumes (n,) [m3] of the snow at the start; dx: grid spacing [m].
    """
    least = LEAST_CELLS * dx
    if not len(volumes):
        return least
    covered = len(np.unique(np.floor(positions[:, :2] / least), axis=0)) * least**2
    flow_depth = FLOW_SHARE * volumes.sum() / covered
    return max(least, float(np.sqrt(GRAINS * volumes.mean() / flow_depth)))


class PeakMaps:
    """Largest flow depth, speed and pressure that each plan cell has seen, and the depth at the start and now.

    depth [m], vertical: what the snow over a cell would fill at its initial density, by the cell's plan area (the
    volume of loose grains means nothing, their mass does);
    speed [m/s]: mean over the mass in the cell, which is the depth average of the flow;
    pressure [Pa]: rho v^2, with rho the initial density and v^2 the mean over the same mass: the stagnation pressure
    without the factor of an obstacle's shape.
    arrival_time [s]: when the flow first was at least `flow_depth` [m] deep; late by no more than the fastest particle
    needs for one map cell.
    Speed and pressure count while the flow is at least `flow_depth` deep (`FLOW_SHARE`). NaN where no snow came.
    """

    def __init__(self, solver, grid):
        """grid: cells of the maps (`snowmpm.results.map_grid.MapGrid`)."""
        self._solver = solver
        self.lower, self.cell, self.shape = grid.lower, grid.cell, grid.shape
        self.values = {name: np.full(self.shape, np.inf if name == "arrival_time" else 0.0) for name in UNITS}
        window, depth, _, _ = self._totals()
        self.values["release_depth"][window] = depth
        self.restore(self.values)

    def restore(self, values):
        """Take over `values`, name -> (columns along x, rows along y). InputError for maps of another grid."""
        if values.keys() != UNITS.keys() or values["peak_depth"].shape != self.shape:
            raise InputError("the checkpoint holds maps of another grid or of another version of the program: start"
                             " anew with --overwrite")
        self.values, depth = values, values["release_depth"]
        self.flow_depth = FLOW_SHARE * float(depth[depth > 0.0].mean()) if depth.any() else 0.0

    def _totals(self):
        """Window (slices) of the map that may hold snow, and depth, mean speed and pressure now in it."""
        window, sums = self._solver.particles.sums_in_plan(self.lower, self.cell, self.shape)
        volume, mass, momentum, energy = np.moveaxis(sums, -1, 0)
        depth = volume / self.cell**2
        return window, depth, momentum / np.maximum(mass, 1e-300), energy / np.maximum(volume, 1e-300)

    def see(self):
        """Take in the state that the solver is in."""
        window, depth, speed, pressure = self._totals()
        flows = depth >= self.flow_depth
        for name, now in (("peak_depth", depth), ("peak_speed", speed * flows), ("peak_pressure", pressure * flows)):
            self.values[name][window] = np.maximum(self.values[name][window], now)
        now = np.where(flows & (depth > 0.0), self._solver.time, np.inf)
        self.values["arrival_time"][window] = np.minimum(self.values["arrival_time"][window], now)
        self.values["deposit_depth"][:] = 0.0
        self.values["deposit_depth"][window] = depth

    def rasters(self):
        """name -> (values (rows along y, columns along x), x0, y0, cell) with the centre of the first cell."""
        x0, y0 = self.lower + 0.5 * self.cell
        touched = self.values["peak_depth"] > 0.0
        return {name: (np.where(touched & np.isfinite(values), values, np.nan).T, x0, y0, self.cell)
                for name, values in self.values.items()}
