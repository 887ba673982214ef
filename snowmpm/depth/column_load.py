"""What a component makes of the columns of a depth-averaged flow: the point of its kernels for one that carries some of
their weight, or lets some of them move apart from the others."""

from collections.abc import Mapping

from snowmpm.depth.nodes import NODE


class ColumnLoad:
    """Columns hold more than their snow, and the ground bears less than their weight. One component has it at a time
    ("the weight of columns"). Kernels contain the functions of its class.

    numbers: Taichi (columns,) vectors of its own, which kernels may change; set_of (materials,): the set of nodes that
    columns of a material have.
    """

    sets = 1
    """of nodes: columns feel each other at those of their own set"""
    node_size = NODE
    """numbers of a node; those behind NODE are its own"""
    steep = NODE
    """place of the one of these whose gradient columns want"""
    sizes: Mapping[str, int] = {}
    """of numbers of a column as output reads them, by name"""
    mass_column = ""
    """of these, the one whose first number is a mass in a volume of snow [kg/m3] that columns have beside that of their
    material"""

    @staticmethod
    def pushed(real):
        """Taichi function (numbers, p, beside, slope, push) -> push: acceleration by other columns, before it is on the
        ground. beside: means of the own numbers of nodes around column p; slope: gradient of the one at `steep`, in
        cells. With more than one set."""

    @staticmethod
    def borne(real):
        """Taichi function (numbers, p, own, density, beside, depth, normal, thickness) -> ti.Vector([density that the
        ground feels, density of the column over all of the depth, its share of the depth, part of the dry friction that
        it gets, normal stress of the friction [Pa]]). own: above 0 in the second set; depth [m]: vertical; normal
        [m/s2]: force of the ground per mass; thickness [m]."""

    def densities(self, of_laws):
        """(materials,) [kg/m3] of the snow alone, and of columns with all that they hold."""
        raise NotImplementedError

    def fill(self, columns, cells, material):
        """Make the numbers of `columns.Columns` at time zero in cells (n, 2), of materials (n,)."""
        raise NotImplementedError

    def take(self, keep):
        """Keep the columns with keep (n,) true."""
        raise NotImplementedError

    def copied(self, rows):
        """Function (material (n,), thickness (n,) [m], 1 / cos of the slope (n,)) -> `sizes` (n, k), of rows of columns
        as they are now."""
        raise NotImplementedError

    def share(self, material, thickness, time):
        """Share (n,) of the weight of columns of a thickness [m] that the ground bears after a time [s], about."""
        raise NotImplementedError

    @property
    def bytes_per_column(self):
        """Of its numbers."""
        raise NotImplementedError
