"""What the grid keeps at a node: one vector, so that a step reads and writes it at once.

    0 .. dim - 1: momentum, then velocity;   MASS: mass
    SECOND .. SECOND + dim - 1 (FLIP and AFLIP only): internal impulse, then the velocity before it while surfaces act,
    then the change of velocity; SPARE: of the one component that asks for it (`kernel_api.Inlined.impulse`)

Eight single-precision numbers are one vector register of a CPU: a node of FLIP costs little more than one without.
"""

from snowmpm.compiler import ti
from snowmpm.particles.blocks import EDGE
from snowmpm.particles.store import LARGEST_INDEX

MASS, SECOND, SPARE = 3, 4, 7


def node_size(flip):
    """Numbers of a node."""
    return 2 * SECOND if flip else SECOND


def node_vector(real, flip):
    """Taichi type of a node."""
    return ti.types.vector(node_size(flip), real)


def node_mask(flip):
    """The number of a node has no other bits. Kernels say so, since the compiler must doubt otherwise, for fear of
    indices beyond 32 bits, that neighbour nodes follow each other, and works out the place of each."""
    return LARGEST_INDEX // (2 * node_size(flip))


def block_nodes(dim):
    """Nodes of a block."""
    return EDGE[dim] ** dim
