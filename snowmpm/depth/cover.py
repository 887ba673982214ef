"""The snow cover that a depth-averaged flow takes up."""

import numpy as np

from snowmpm.compiler.arrays import int_array, real_array
from snowmpm.depth.plan_grid import MARGIN


class Cover:
    """law: class of `ground.entrainment`, None for a ground without snow cover; numbers (rows, parameters) and place
    (n_nodes,), the row of each node; mass (n_nodes,): left over each node's cell [kg]; lowering (n_nodes,): how far the
    ground sinks where a kilogram is taken [m]; under (n_nodes,): places in the ground's table."""

    def __init__(self, grid, bed, numbers=None, law=None):
        """numbers: a row of the law's PARAMETERS, or rows by node."""
        self.law = law
        rows = np.zeros((1, 1)) if law is None else np.atleast_2d(numbers)
        several = len(rows) > 1
        self.numbers = real_array(rows)
        self.place = int_array(np.arange(grid.n_nodes) if several else np.zeros(grid.n_nodes))
        size = grid.n_nodes if law else 1
        mass, lowering, under = np.zeros(size), np.zeros(size), np.zeros(size, int)
        if law:
            names = law.PARAMETERS._fields
            thickness, density = (rows[:, names.index(name)] for name in ("thickness", "density"))
            cos2 = grid.flat(bed.cos2)
            inside = grid.flat(np.ones(grid.shape)) * (cos2 > 0.0)
            # thickness is normal to the ground; over a cell in plan lies thickness / cos of it
            mass = inside * density * thickness * grid.dx**2 / np.sqrt(np.where(cos2 > 0.0, cos2, 1.0))
            mass[grid.nodes()[bed.holes]] = 0.0
            lowering = np.broadcast_to(1.0 / (density * grid.dx**2), mass.shape)
            i, j = np.indices(grid.shape)
            under = grid.flat((i + MARGIN) * bed.stride + j + MARGIN)
        self.mass, self.lowering, self.under = real_array(mass), real_array(lowering), int_array(under)

    def state(self):
        """What changes, by name."""
        return {"mass": self.mass.to_numpy()} if self.law else {}

    def restore(self, state):
        """Take over a `state()`."""
        if self.law:
            self.mass.from_numpy(np.ascontiguousarray(state["mass"]))
