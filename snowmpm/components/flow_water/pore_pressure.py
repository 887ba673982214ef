"""Excess pore pressure in each column of a depth-averaged flow."""

import functools

import numpy as np

from snowmpm.compiler import ti
from snowmpm.compiler.arrays import int_array
from snowmpm.compiler.runtime import DTYPES
from snowmpm.components.flow_water.bearing import BUOYANT, DRAINED, EFFECTIVE, LOAD, OVERBURDEN, PORE, WATER
from snowmpm.components.flow_water.consolidation import consolidate_kernel
from snowmpm.components.flow_water.two_phase import TwoPhaseWater

SIZES = {"water": 3, "excess_pressure": 1}
"""Columns of numbers as output reads them: water per volume of snow [kg/m3], pore pressure at the ground [Pa] and
volume of the grains over that of the snow [-]; what the pressure exceeds the hydrostatic one by [Pa]."""


class PorePressure:
    """Of all columns. pores (n,): Taichi, PORE numbers each (`bearing`); excess (n, 3 layers): the mesh
    (`consolidation`)."""

    def __init__(self, water, material, drained, drains, precision):
        """water: `one_phase.FlowWater`.
        material (n,): index of each column; drained (n,): whether the ground under it lets water out; drains
        (n_nodes,): the same of the ground under each node."""
        self.water, self._precision = water, precision
        self.drains = int_array(drains)
        pores = np.zeros((len(material), PORE))
        pores[:, EFFECTIVE], pores[:, LOAD] = 1.0 - water.excess, -1.0
        pores[:, BUOYANT], pores[:, OVERBURDEN] = water.buoyant[material], water.overburden[material]
        pores[:, WATER], pores[:, DRAINED] = water.hydrostatic[material], drained
        self._fill(pores, np.zeros((len(material), 3 * water.layers)))

    def _fill(self, pores, excess):
        real, numpy_real = DTYPES[self._precision]
        self.count = len(pores)
        self.pores = ti.Vector.ndarray(PORE, real, max(1, self.count))
        self.excess = ti.ndarray(real, (max(1, self.count), excess.shape[1]))
        if self.count:
            self.pores.from_numpy(np.ascontiguousarray(pores, numpy_real))
            self.excess.from_numpy(np.ascontiguousarray(excess, numpy_real))

    @property
    def bytes_per_column(self):
        """Of its numbers."""
        return (PORE + 3 * self.water.layers) * np.dtype(DTYPES[self._precision][1]).itemsize

    def take(self, keep):
        """Keep the columns with keep (n,) true."""
        self._fill(self.pores.to_numpy()[: self.count][keep], self._table()[keep])

    def _table(self):
        return self.excess.to_numpy()[: self.count]

    def consolidate(self, store, dt, serial):
        """Take the pressures of the columns that flow through a step of dt [s]."""
        rate = self.water.consolidation * dt / self.water.level**2
        consolidate_kernel(DTYPES[self._precision][0], serial)(
            self.excess, self.pores, store.reals, store.cells, store.grid.lookup, self.drains, rate, store.flowing)

    def profile(self):
        """Excess pressure (n, layers + 1) [Pa] from the ground to the water table, as of the last step."""
        table = self._table()[:, : self.water.layers].astype(float)
        return np.column_stack([table, np.zeros(len(table))])

    def copied(self, rows):
        """Function (material (n,), thickness (n,) [m], 1 / cos of the slope (n,)) -> SIZES (n, 4), of rows
        of columns as they are now. Thickness and slope are for those that have not moved yet."""
        pores = self.pores.to_numpy()[: self.count][rows].astype(float)
        base = self._table()[rows, 0].astype(float)
        return functools.partial(self._read, pores, base)

    def _read(self, pores, base, material, thickness, metric):
        water, new = self.water, pores[:, LOAD] < 0.0
        mixed = isinstance(water, TwoPhaseWater)
        grains = water.density / pores[:, WATER] if mixed else water.grains[material]
        bearing = pores[:, BUOYANT] * water.gravity * thickness / metric
        load = np.where(new, bearing * grains if mixed else bearing, pores[:, LOAD])
        excess = np.where(new, np.where(pores[:, DRAINED] > 0.0, 0.0, water.excess * load), base)
        hydrostatic = pores[:, WATER] * load / pores[:, BUOYANT]
        return np.column_stack([water.water[material], hydrostatic + excess, grains, excess])

    def state(self):
        """What changes, by name."""
        return {"pores": self.pores.to_numpy()[: self.count], "excess": self._table()}

    def restore(self, state):
        """Take over a `state()`."""
        self._fill(state["pores"], state["excess"])
