"""The arrays of columns, nodes and ground that kernels take, in groups (`compiler.groups`)."""

from typing import NamedTuple

from snowmpm.compiler.groups import Array, Real


class ColumnArrays(NamedTuple):
    """Cells and numbers of the columns, material of each, density of each material [kg/m3]."""

    cells: Array
    reals: Array
    material: Array
    density: Array


class NodeArrays(NamedTuple):
    """lookup: place of a node along each axis (`PlanGrid`); values: what columns feel of each other, totals: sums over
    the columns (`depth.nodes`); live: tiles that have some; cos2 of the ground; set_of: how much further on the nodes
    of a material are."""

    lookup: Array
    values: Array
    totals: Array
    live: Array
    cos2: Array
    set_of: Array


class Tallies(NamedTuple):
    """Sums of the columns by workers, `copies` of them of n_nodes each, and the tiles that were touched, `stride` of
    each worker; unit: the volume that they are counted in [m3]."""

    sums: Array
    touched: Array
    copies: int
    n_nodes: int
    stride: int
    unit: Real


class GroundArrays(NamedTuple):
    """bed: heights of the nodes and beyond the sides, rows of stride; place: row of each node among the numbers of its
    friction; walls (2, 4): of each axis whether there is one at either end, its nodes, and whether it repeats."""

    bed: Array
    stride: int
    place: Array
    friction: Array
    walls: Array


class CoverArrays(NamedTuple):
    """Those of an `intake.Intake`."""

    numbers: Array
    place: Array
    mass: Array
    lowering: Array
    under: Array


class Segments(NamedTuple):
    """Bounds of the segments of columns that each worker takes, what each segment reports, number of columns."""

    bounds: Array
    report: Array
    n: int
