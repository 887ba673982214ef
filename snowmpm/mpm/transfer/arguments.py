"""What scatter and gather take, in groups (`compiler.groups`)."""

from typing import NamedTuple

from snowmpm.compiler.groups import Array, Real, Vectors


class Particles(NamedTuple):
    """Rows of all particles and the slot that they begin in, index of each one's material, numbers of the materials,
    and the law of each (`particles.store`, `particles.material_table`)."""

    reals: Array
    slot_offset: int
    material: Array
    materials: Array
    law_of: Array


class Blocks(NamedTuple):
    """First particle of each block, and the cut of the blocks into chunks: one block a thread."""

    start: Array
    chunk_bounds: Array


class Owners(NamedTuple):
    """Block of each particle, and how many particles there are: one particle a thread."""

    block_of: Array
    n: int


class Nodes(NamedTuple):
    """Tiles of node vectors, and those of what forces change in a step; the box of each tile that particles reach."""

    active_nodes: Array
    tiles: Vectors
    changes: Vectors
    n_tiles: int


class Step(NamedTuple):
    """dt [s], dx [m], share of FLIP."""

    dt: Real
    dx: Real
    flip_ratio: Real


class Reports(NamedTuple):
    """Of each block, and their sum."""

    of_blocks: Array
    total: Array
