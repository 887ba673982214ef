"""The arrays of contact that kernels take, in groups (`compiler.groups`)."""

from typing import NamedTuple

from snowmpm.compiler.groups import Array, Double


class ContactNodes(NamedTuple):
    """Nodes of the contact blocks from offset on, coordinates of the blocks, how a solid moves (`Surface.motion`)."""

    nodes: Array
    offset: int
    coordinates: Array
    motion: Array


class LineArrays(NamedTuple):
    """The tables of `lines.Lines`: first line of each contact block, places and numbers of each line, and the same of
    deep nodes."""

    start: Array
    places: Array
    numbers: Array
    deep_start: Array
    deep: Array
    deep_normals: Array


class WallArrays(NamedTuple):
    """What tells how far nodes of the contact blocks are from a surface: coordinates and neighbours of the blocks,
    slots of them in `walls`; or axis, sign and level of a `surface.Plane`."""

    coordinates: Array
    neighbours: Array
    slots: Array
    walls: Array
    axis: int
    sign: int
    level: Double
