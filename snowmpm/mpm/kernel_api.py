"""What components use of explicit MPM: its nodes and weights, and the points where kernels contain their functions."""

from snowmpm.mpm.contact.field_pairs import FieldPairs
from snowmpm.mpm.contact.surface import Plane
from snowmpm.mpm.contact.walls import FREE
from snowmpm.mpm.grid import TILE
from snowmpm.mpm.node import MASS, SECOND, SPARE, block_nodes, node_size, node_vector
from snowmpm.mpm.node_copy import copy_kernel
from snowmpm.mpm.transfer.interpolation import interpolation
from snowmpm.mpm.transfer.stencil import STENCILS

__all__ = ["FREE", "MASS", "SECOND", "SPARE", "STENCILS", "TILE", "FieldPairs", "Inlined", "Plane", "block_nodes",
           "copy_kernel", "interpolation", "node_size", "node_vector"]


class Inlined:
    """Functions of a component that the kernels of a step contain.

    A subclass is a frozen dataclass: its numbers are constants of the kernels, other ones compile others.
    column: of a particle, that they are about; keeps: whether `gradient` changes it, so that kernels store it.
    """

    column = ""
    keeps = False

    def impulse(self, dim, real):
        """Taichi function of what a particle gives to its nodes: (impulse, ratio, own, dx) -> impulse, pull, spare.

        impulse (dim, dim): -dt V tau / dx [N s], which goes by the slopes of the weights; pull (dim,) [N s]: by the
        weights alone; spare: to the spare number of the nodes; ratio: J; own: the numbers of its column; dx [m]. One
        component has it at a time ("the spare number of a node"), with FLIP. None: the component has none.
        """
        return None

    def gradient(self, dim, real):
        """Taichi function of the velocity gradient before the law: (L, v, ratio, own, dt, dx) -> L, own.

        L [1/s], v [m/s]: of the nodes at the particle; ratio: J before the step; own: the numbers of its column; dt [s]
        and dx [m]. Components that change L have it one at a time ("the deformation of particles"); one that
        only reads L need not own it. None: the component has none.
        """
        return None
