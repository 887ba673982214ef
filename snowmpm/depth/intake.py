"""What a depth-averaged flow may take up from the ground: the point of its kernels for a component that has some."""

import numpy as np

from snowmpm.compiler.arrays import int_array, real_array
from snowmpm.depth.arrays import CoverArrays


class Intake:
    """What kernels ask of it.

    law: class with PARAMETERS, a NamedTuple, and the Taichi function intake(prm, density, tau, speed, depth) ->
    ti.Vector([mass rate [kg/m2/s], part of tau [Pa] by which friction acts]); None: nothing is taken up. numbers (rows,
    parameters) and place (n_nodes,), the row of each node; mass (n_nodes,): left over each node's cell [kg]; lowering
    (n_nodes,): how far the ground sinks where a kilogram is taken [m]; under (n_nodes,): places in the ground's table.
    """

    def __init__(self, law, numbers, place, mass, lowering, under):
        self.law, self.numbers, self.place = law, numbers, place
        self.mass, self.lowering, self.under = mass, lowering, under

    @property
    def arrays(self):
        """What kernels take of it."""
        return CoverArrays(self.numbers, self.place, self.mass, self.lowering, self.under)

    @classmethod
    def none(cls, grid):
        """Of a ground that gives nothing."""
        one, zero = real_array(np.zeros(1)), int_array(np.zeros(1, int))
        return cls(None, real_array(np.zeros((1, 1))), int_array(np.zeros(grid.n_nodes)), one, one, zero)
