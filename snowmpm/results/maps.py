"""Peak values in plan over a run, and the deposit: the maps of hazard mapping.

The depth in a plan cell is a number of particles, n = depth x area / volume of a particle. It scatters by sqrt(n), and
a peak over time takes the largest of many such counts. If a cell holds only two particles at the flow depth, scattered
particles of a sheet half as deep make it affected; if it holds `GRAINS`, they rarely do. In cells too small for the
particles, the affected area depends on the cell size.

The size of this error follows from the frames of two real avalanches (73 000 to 147 000 particles;
tests/test_avalanche_on_terrain.py), with only every second, fourth or eighth particle counted, with 2, 4 or 8 times the
volume. Number of particles in a cell (20 to 50 m) at the flow depth, and excess of the affected area over that with all
particles:

    6: 19 %     11 to 14: 5 to 11 %     21 to 29: 2 to 7 %     40 to 57: 1 to 4 %     from 80 on: 1 %
"""

import numpy as np

from snowmpm.errors import InputError
from snowmpm.quantities.motion import MOVING_SPEED
from snowmpm.quantities.table import PASSED, RASTERS, units_of

UNITS = units_of((*RASTERS, *PASSED))
"""Unit of each raster."""

THICK = {"peak_thickness": "peak_depth", "deposit_thickness": "deposit_depth"}
"""Rasters that follow from another one and the slope of the ground."""

SIDE = 4
"""Points along a side of a map cell at which the slope of its ground is taken: on the cells of a raster of 10 m one
alone misses the mean by up to 97 %."""

FLOW_SHARE = 0.1
"""Depth over the mean release depth below which particles over a plan cell are scattered and do not count as flow:
their speed is not that of the avalanche."""

GRAINS = 24
"""Particles in a plan cell at the flow depth: their scatter adds 2 to 7 per cent to the affected area."""

LEAST_CELLS = 2.0
"""Least side of a plan cell in grid spacings: no map is finer than the grid."""


def cell_for(positions, volumes, dx, grain=None):
    """Side [m] of plan cells that hold `GRAINS` particles at the flow depth, and are `LEAST_CELLS` wide or more.

    positions (n, 3) [m] and volumes (n,) [m3] of the snow at the start; dx: grid spacing [m];
    grain: volume of a particle [m3] where it is another than at the start.
    """
    least = LEAST_CELLS * dx
    if not len(volumes):
        return least
    covered = len(np.unique(np.floor(positions[:, :2] / least), axis=0)) * least**2
    flow_depth = FLOW_SHARE * volumes.sum() / covered
    return max(least, float(np.sqrt(GRAINS * (grain or volumes.mean()) / flow_depth)))


KEPT = tuple(name for name in UNITS if name not in THICK)
"""Rasters that are kept up during a run."""


class PeakMaps:
    """Largest flow depth, speed and pressure in each plan cell so far, and the depth at the start and now.

    depth [m], vertical: volume of the snow over a cell at its initial density, by the cell's plan area (the volume of
    loose particles is meaningless, their mass is not);
    speed [m/s]: mean over the mass in the cell, which is the depth average of the flow;
    pressure [Pa]: rho v^2, with rho the initial density and v^2 the mean over the same mass: the stagnation pressure
    without the factor of an obstacle's shape.
    momentum [m2/s]: depth times speed; made normal to the ground in `rasters`;
    arrival_time [s]: when the flow first was at least `flow_depth` [m] deep; the error is at
    most the time in which the fastest particle crosses one map cell;
    flow_duration [s]: from then until such a flow was last faster than `MOVING_SPEED`;
    passed [m2], east and north: depth times velocity times the time since the maps were last updated, added up.
    Speed, momentum and pressure count while the flow is at least `flow_depth` deep (`FLOW_SHARE`). NaN where no snow
    arrived.
    Snow that is not released yet, or that was laid down, is no part of the flow: it counts in the depths at the start
    and now only.
    """

    def __init__(self, solver, grid):
        """grid: cells of the maps (`snowmpm.results.map_grid.MapGrid`)."""
        self.lower, self.cell, self.shape = grid.lower, grid.cell, grid.shape
        self.values = {name: np.full(self.shape, np.inf if name == "arrival_time" else 0.0) for name in KEPT}
        window, depth, *_ = self._totals(solver)
        self._lay(solver, "release_depth", window, depth)
        self._lay(solver, "deposit_depth", window, depth)
        self.seen = solver.time
        self.restore(self.state())

    def state(self):
        """All that a continuation needs, by name."""
        return {**self.values, "seen": np.array([self.seen])}

    def restore(self, state):
        """Take over a `state()`. InputError for maps of another grid."""
        if state.keys() != {*KEPT, "seen"} or state["peak_depth"].shape != self.shape:
            raise InputError("the checkpoint holds maps of another grid or of another version of the program: start"
                             " anew with --overwrite")
        self.values, self.seen = {name: state[name] for name in KEPT}, float(state["seen"][0])
        depth = self.values["release_depth"]
        self.flow_depth = FLOW_SHARE * float(depth[depth > 0.0].mean()) if depth.any() else 0.0

    def _totals(self, solver):
        """Window (slices) of the map that may hold snow, and depth, mean speed, pressure, and depth times velocity
        (2, ...) now in it."""
        window, sums = solver.particles.sums_in_plan(self.lower, self.cell, self.shape)
        volume, mass, momentum, energy, *flux = np.ascontiguousarray(np.moveaxis(sums, -1, 0))
        depth = volume / self.cell**2
        momentum /= np.maximum(mass, 1e-300, out=mass)
        energy /= np.maximum(volume, 1e-300, out=volume)
        return window, depth, momentum, energy, [one / self.cell**2 for one in flux]

    def see(self, solver, deposit=True):
        """Update the maps with the current state of the solver. deposit: whether to set the map of the deposit as well,
        of which only the last state counts."""
        window, depth, speed, pressure, flux = self._totals(solver)
        since, self.seen = solver.time - self.seen, solver.time
        flows = depth >= self.flow_depth
        peaks = {name: values[window] for name, values in self.values.items()}
        np.maximum(peaks["peak_depth"], depth, out=peaks["peak_depth"])
        np.maximum(peaks["peak_speed"], speed, out=peaks["peak_speed"], where=flows)
        np.maximum(peaks["peak_pressure"], pressure, out=peaks["peak_pressure"], where=flows)
        np.maximum(peaks["peak_momentum"], depth * speed, out=peaks["peak_momentum"], where=flows)
        for one, through in zip(PASSED, flux, strict=True):
            peaks[one.name] += since * through
        arrived = flows & (depth > 0.0)
        np.minimum(peaks["arrival_time"], solver.time, out=peaks["arrival_time"], where=arrived)
        moving = arrived & (speed > MOVING_SPEED)
        np.subtract(solver.time, peaks["arrival_time"], out=peaks["flow_duration"], where=moving)
        if deposit:
            self._lay(solver, "deposit_depth", window, depth)

    def _lay(self, solver, name, window, depth):
        """Set a map to the depth of the flow and of what rests."""
        resting = solver.particles.resting_in_plan(self.lower, self.cell, self.shape)
        self.values[name][:] = 0.0 if resting is None else resting / self.cell**2
        self.values[name][window] += depth

    def rasters(self, normal=None):
        """name -> (values (rows along y, columns along x), x0, y0, cell) with the centre of the first cell.

        normal: function of plan positions (k, 2) -> unit normals of the ground (k, 3); None where there is none."""
        x0, y0 = self.lower + 0.5 * self.cell
        touched = self.values["peak_depth"] > 0.0
        values = {name: self.values[name] for name in KEPT}
        if normal is not None:
            steepness = self._cosine(touched, normal)
            values |= {name: steepness * self.values[depth] for name, depth in THICK.items()}
            values["peak_momentum"] = steepness * values["peak_momentum"]
        return {name: (np.where(touched & np.isfinite(one), one, np.nan).T, x0, y0, self.cell)
                for name, one in values.items()}

    def _cosine(self, touched, normal):
        """Mean cosine of the ground's slope over each touched cell (columns, rows); 1 elsewhere, and over holes."""
        cells, found = np.argwhere(touched), np.ones(touched.shape)
        shares = (np.arange(SIDE) + 0.5) / SIDE
        total, known = np.zeros(len(cells)), np.zeros(len(cells))
        for share in np.stack(np.meshgrid(shares, shares), axis=-1).reshape(-1, 2):
            up = normal(self.lower + self.cell * (cells + share))[:, -1]
            there = np.isfinite(up)
            total += np.where(there, up, 0.0)
            known += there
        found[touched] = np.where(known > 0.0, total / np.maximum(known, 1.0), 1.0)
        return found
