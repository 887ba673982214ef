"""Nodes that ground and sides do not touch, since a layer thinner than a cell holds them (`.column`).

A node that a point of an interface reaches has a positive SPARE. While ground and sides act, its mass waits there,
and the node counts as empty.
"""

import functools

from snowmpm.compiler import ti
from snowmpm.compiler.launch import taichi_kernel
from snowmpm.mpm.kernel_api import MASS, SPARE, node_vector


@functools.cache
def hiding_kernels(real, serial):
    """`hide` and `show` the marked ones of n nodes from contact_offset on; of transfers whose nodes have two halves."""
    return tuple(_turning_kernel(real, serial, hides) for hides in (True, False))


def _turning_kernel(real, serial, hides):
    of_node = node_vector(real, True)

    @taichi_kernel
    def turn(nodes: ti.types.ndarray(dtype=of_node, ndim=1), contact_offset: int, n: int):
        ti.loop_config(serialize=ti.static(serial))
        for q in range(n):
            node = nodes[contact_offset + q]
            if node[SPARE] > 0.0:
                if ti.static(hides):
                    node[SPARE], node[MASS] = node[MASS], ti.cast(0.0, real)
                else:
                    node[MASS] = node[SPARE]
                nodes[contact_offset + q] = node

    return turn
