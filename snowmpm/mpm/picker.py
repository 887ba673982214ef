"""Lists of work: surfaces act on all contact blocks, or on those that a list names."""

import functools

from snowmpm.compiler import ti


@functools.cache
def picker(lists):
    """Taichi function: the k-th number of a list, or k itself where all is visited (lists false)."""

    @ti.func
    def pick(order: ti.template(), k):
        n = k
        if ti.static(lists):
            n = order[k]
        return n

    return pick
