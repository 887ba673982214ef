"""Copies of vectors of nodes from one array to another."""

import functools

from snowmpm.compiler import ti
from snowmpm.compiler.launch import taichi_kernel


@functools.cache
def copy_kernel(size, real):
    """Kernel copy(source, begin, target, first, n) of vectors of `size` numbers: n of `source` from `begin` on, to
    `target` from `first` on."""
    vector = ti.types.vector(size, real)

    @taichi_kernel
    def copy(source: ti.types.ndarray(dtype=vector, ndim=1), begin: int, target: ti.types.ndarray(dtype=vector, ndim=1),
             first: int, n: int):
        for q in range(n):
            target[first + q] = source[begin + q]

    return copy
