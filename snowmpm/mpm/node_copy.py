"""Copies of vectors of nodes from one array to another."""

import functools

import taichi as ti

from snowmpm.compiler.launch import taichi_kernel


@functools.cache
def copy_kernel(real):
    """Kernel copy(source, begin, target, first, n): n vectors of `source` from `begin` on, to `target` from `first`
    on."""
    vec4 = ti.types.vector(4, real)

    @taichi_kernel
    def copy(source: ti.types.ndarray(dtype=vec4, ndim=1), begin: int, target: ti.types.ndarray(dtype=vec4, ndim=1),
             first: int, n: int):
        for q in range(n):
            target[first + q] = source[begin + q]

    return copy
