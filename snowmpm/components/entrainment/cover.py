"""The snow cover that a depth-averaged flow takes up."""

import numpy as np

from snowmpm.compiler.arrays import int_array, real_array
from snowmpm.depth.kernel_api import MARGIN, Intake


class Cover(Intake):
    """Of a law of `.laws`."""

    def __init__(self, grid, bed, law, numbers):
        """law: its class; numbers: a row of its PARAMETERS, or rows by node."""
        rows = np.atleast_2d(numbers)
        names = law.PARAMETERS._fields
        thickness, density = (rows[:, names.index(name)] for name in ("thickness", "density"))
        cos2 = grid.flat(bed.cos2)
        inside = grid.flat(np.ones(grid.shape)) * (cos2 > 0.0)
        # thickness is normal to the ground; over a cell in plan lies thickness / cos of it
        mass = inside * density * thickness * grid.dx**2 / np.sqrt(np.where(cos2 > 0.0, cos2, 1.0))
        mass[grid.nodes()[bed.holes]] = 0.0
        i, j = np.indices(grid.shape)
        super().__init__(law, real_array(rows),
                         int_array(np.arange(grid.n_nodes) if len(rows) > 1 else np.zeros(grid.n_nodes)),
                         real_array(mass), real_array(np.broadcast_to(1.0 / (density * grid.dx**2), mass.shape)),
                         int_array(grid.flat((i + MARGIN) * bed.stride + j + MARGIN)))

    def state(self):
        """What changes, by name."""
        return {"mass": self.mass.to_numpy()}

    def restore(self, state):
        """Take over a `state()`."""
        self.mass.from_numpy(np.ascontiguousarray(state["mass"]))
