"""The pore voxels of an image as nodes of the lattice, and where each finds what streams to it.

Between two steps the number A[i, n] is what comes to node n with velocity i. An even step reads and writes only what
is of its node; an odd step reads and writes at the neighbours, so that one array is enough (AA pattern, Bailey et al.
2009, doi:10.1109/ICPP.2009.38). The odd step finds its places in one table: of velocity i of node n

    neighbour m = n + e_i in a pore:  A[i, m];       in the ice: A[opposite of i, n], which is a bounce half-way
"""

from dataclasses import dataclass

import numpy as np

from snowmpm import memory
from snowmpm.micro.lattice import VELOCITIES
from snowmpm.micro.pores import SMALLER

BYTES = 350
"""Most memory of a pore voxel (measured at 128^3): numbers in float32, the table, copies of both, and velocities."""


@dataclass(frozen=True)
class PoreLattice:
    """nodes (n, 3): voxels of the pores; table (18, n) int32: places in the flat array of A (19, n); shape (3,)."""

    nodes: np.ndarray
    table: np.ndarray
    shape: tuple

    @property
    def count(self):
        return len(self.nodes)


def pore_lattice(pores, walls=(False, False, False), slide=(0, 0)):
    """`PoreLattice` of an image (nx, ny, nz), True in pores. Its sides are periodic, or no-slip walls along the axes
    with `walls`. slide: shift along x and y, in voxels, of the periodic image above. InputError when it does not fit
    into memory."""
    pores = np.asarray(pores, bool)
    count = int(pores.sum())
    memory.require(float(BYTES) * count + 4.0 * pores.size, "SAMPLE: the pores of the image", SMALLER)
    number = np.full(pores.shape, -1, np.int32)
    number[pores] = np.arange(count, dtype=np.int32)
    nodes = np.argwhere(pores).astype(np.int32)
    table = np.empty((len(VELOCITIES) - 1, count), np.int32 if 19 * count < 2**31 else np.int64)
    own = np.arange(count)
    for i, e in enumerate(VELOCITIES[1:], start=1):
        there, open_side = nodes + e, np.ones(count, bool)
        for axis in range(3):
            if walls[axis]:
                open_side &= (there[:, axis] >= 0) & (there[:, axis] < pores.shape[axis])
            if axis == 0:
                over = there[:, 2] // pores.shape[2]
                there[:, :2] -= over[:, None] * np.asarray(slide)
            there[:, axis] %= pores.shape[axis]
        neighbour = np.where(open_side, number[tuple(there.T)], -1)
        opposite = i + 1 if i % 2 else i - 1
        table[i - 1] = np.where(neighbour >= 0, i * count + neighbour, opposite * count + own)
    return PoreLattice(nodes, table, pores.shape)
