"""Peak values in plan over a run: what hazard mapping works with."""

import functools

import numpy as np
import taichi as ti

from snowmpm import runtime
from snowmpm.blocks import EDGE
from snowmpm.material_table import DENSITY
from snowmpm.particles import accessors

UNITS = {"peak_depth": "m", "peak_speed": "m/s", "deposit_depth": "m"}


@functools.cache
def totals_kernel(layout, real):
    """Kernel that adds up what lies over plan cells of `width` grid cells.

    totals (columns along x, rows along y, 3): initial volume, mass, mass times speed. One thread, so that the sums do
    not depend on the number of threads.
    """
    edge, at = EDGE[layout.dim], layout.offsets
    access = accessors(layout)

    @ti.kernel
    def add_up(reals: ti.types.ndarray(), turn: int, material: ti.types.ndarray(), materials: ti.types.ndarray(),
               start: ti.types.ndarray(), coordinates: ti.types.ndarray(), totals: ti.types.ndarray(), width: int,
               n_blocks: int):
        ti.loop_config(serialize=True)
        for b in range(n_blocks):
            places = access.places(reals, turn)
            for p in range(start[b], start[b + 1]):
                x = access.load(reals, places, p, at["position"], 2)
                i = ti.floor((ti.cast(edge * coordinates[b, 0], ti.f64) + x[0]) / width, ti.i32)
                j = ti.floor((ti.cast(edge * coordinates[b, 1], ti.f64) + x[1]) / width, ti.i32)
                if 0 <= i < totals.shape[0] and 0 <= j < totals.shape[1]:
                    volume = access.load(reals, places, p, at["volume"], 1)[0]
                    mass = volume * materials[material[p], DENSITY]
                    totals[i, j, 0] += volume
                    totals[i, j, 1] += mass
                    totals[i, j, 2] += mass * access.load(reals, places, p, at["velocity"], layout.dim).norm()

    return add_up


class PeakMaps:
    """Largest flow depth and speed that each plan cell has seen.

    depth [m], vertical: what the snow over a cell would fill at its initial density, by the cell's plan area (the
    volume of loose grains means nothing, their mass does);
    speed [m/s]: mass-weighted mean over the particles of the cell. NaN where no snow ever was.
    """

    def __init__(self, solver, width):
        """width: side of a plan cell in grid cells; the map starts at the solver's origin and covers its domain."""
        self._solver, self._width = solver, width
        self.lower, self.cell = solver.frame.origin[:2], width * solver.dx
        self.shape = tuple(np.maximum(1, np.ceil(solver.frame.upper[:2] / width).astype(int)))
        self.values = {name: np.zeros(self.shape) for name in ("peak_depth", "peak_speed")}

    def see(self):
        """Take in the state that the solver is in."""
        solver, totals = self._solver, np.zeros((*self.shape, 3))
        store = solver.particles
        with runtime.precision(solver.precision):
            kernel = totals_kernel(store.layout, runtime.DTYPES[solver.precision][0])
            kernel(store.reals, store.turn, store.material, solver.materials.numbers, store.start, store.coordinates,
                   totals, self._width, len(store.blocks))
        depth = totals[:, :, 0] / self.cell**2
        speed = totals[:, :, 2] / np.maximum(totals[:, :, 1], 1e-300)
        np.maximum(self.values["peak_depth"], depth, out=self.values["peak_depth"])
        np.maximum(self.values["peak_speed"], speed, out=self.values["peak_speed"])
        self.values["deposit_depth"] = depth

    def rasters(self):
        """name -> (values (rows along y, columns along x), x0, y0, cell) with the centre of the first cell."""
        x0, y0 = self.lower + 0.5 * self.cell
        touched = self.values["peak_depth"] > 0.0
        return {name: (np.where(touched, values, np.nan).T, x0, y0, self.cell) for name, values in self.values.items()}
