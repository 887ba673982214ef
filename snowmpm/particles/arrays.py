"""The arrays of sorted particles that kernels take, in groups (`compiler.groups`)."""

from typing import NamedTuple

from snowmpm.compiler.groups import Array


class BlockRows(NamedTuple):
    """Tables of a store (`store.accessors`) in the order of blocks: first row and coordinates of each block."""

    reals: Array
    slot_offset: int
    start: Array
    coordinates: Array


class ParticleArrays(NamedTuple):
    """Tables of a store (`store.accessors`), material of each particle, numbers and law of each material."""

    reals: Array
    slot_offset: int
    material: Array
    materials: Array
    law_of: Array
