"""Symmetric 3×3 tensors as vectors, in full or in plane strain.

    6 entries: xx, yy, zz, xy, yz, xz        4 entries: xx, yy, zz, xy  (xz = yz = 0)

The four-entry form is the same three-dimensional tensor with its two zeros left out, so every invariant below is the
three-dimensional one. In plane strain axis 2 (zz) is the direction out of the plane.
"""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from snowmpm.compiler import ti

from .arrays import Array

PAIRS = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))
COMPONENTS = tuple("xyz"[i] + "xyz"[j] for i, j in PAIRS)


def size(dimension: int) -> int:
    """Number of stored entries: 4 in plane strain (dimension 2), 6 in 3-D."""
    return {2: 4, 3: 6}[dimension]


def entries(dimension: int) -> tuple[tuple[int, ...], ...]:
    """Which stored entry is (i, j), i, j < dimension: rows."""
    entry = {pair: k for k, pair in enumerate(PAIRS)}
    axes = range(dimension)
    return tuple(tuple(entry[min(i, j), max(i, j)] for j in axes) for i in axes)


def pack(tensor: ArrayLike, dimension: int = 3) -> NDArray[Any]:
    """(..., 3, 3) symmetric NumPy tensors -> (..., 6) or, for dimension 2, (..., 4)."""
    tensor = np.asarray(tensor)
    return np.stack([tensor[..., i, j] for i, j in PAIRS[: size(dimension)]], axis=-1)


def unpack(vector: ArrayLike) -> NDArray[Any]:
    """(..., 6) or (..., 4) NumPy vectors -> (..., 3, 3) symmetric tensors."""
    vector = np.asarray(vector)
    tensor = np.zeros((*vector.shape[:-1], 3, 3), vector.dtype)
    for k, (i, j) in enumerate(PAIRS[: vector.shape[-1]]):
        tensor[..., i, j] = tensor[..., j, i] = vector[..., k]
    return tensor


def invariants(stress: ArrayLike) -> tuple[Array, Array]:
    """p = −tr(τ)/3, positive in compression, and q = √(3/2 s:s) of (..., 3, 3) NumPy stresses."""
    stress = np.asarray(stress)
    p = -np.trace(stress, axis1=-2, axis2=-1) / 3.0
    deviator = stress + p[..., None, None] * np.eye(3)
    return p, np.sqrt(1.5 * np.einsum("...ij,...ij->...", deviator, deviator))


@ti.func
def trace(a):
    """a_ii."""
    return a[0] + a[1] + a[2]


@ti.func
def contract(a, b):
    """a : b"""
    result = a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + 2.0 * a[3] * b[3]
    if ti.static(a.n == 6):
        result += 2.0 * (a[4] * b[4] + a[5] * b[5])
    return result


@ti.func
def plus_isotropic(a, x):
    """a + x I"""
    b = a
    for i in ti.static(range(3)):
        b[i] += x
    return b


@ti.func
def squared(a):
    """a a, the matrix product."""
    b = a
    if ti.static(a.n == 6):
        b = ti.Vector(
            [
                a[0] * a[0] + a[3] * a[3] + a[5] * a[5],
                a[3] * a[3] + a[1] * a[1] + a[4] * a[4],
                a[5] * a[5] + a[4] * a[4] + a[2] * a[2],
                a[3] * (a[0] + a[1]) + a[5] * a[4],
                a[4] * (a[1] + a[2]) + a[3] * a[5],
                a[5] * (a[0] + a[2]) + a[3] * a[4],
            ]
        )
    else:
        b = ti.Vector([a[0] * a[0] + a[3] * a[3], a[3] * a[3] + a[1] * a[1], a[2] * a[2], a[3] * (a[0] + a[1])])
    return b


@ti.func
def both_products(a, b):
    """a b + b a, which is symmetric."""
    c = 2.0 * a * b
    if ti.static(a.n == 6):
        c = ti.Vector(
            [
                2.0 * (a[0] * b[0] + a[3] * b[3] + a[5] * b[5]),
                2.0 * (a[3] * b[3] + a[1] * b[1] + a[4] * b[4]),
                2.0 * (a[5] * b[5] + a[4] * b[4] + a[2] * b[2]),
                (a[0] + a[1]) * b[3] + a[3] * (b[0] + b[1]) + a[5] * b[4] + a[4] * b[5],
                (a[1] + a[2]) * b[4] + a[4] * (b[1] + b[2]) + a[3] * b[5] + a[5] * b[3],
                (a[0] + a[2]) * b[5] + a[5] * (b[0] + b[2]) + a[3] * b[4] + a[4] * b[3],
            ]
        )
    else:
        c = ti.Vector(
            [
                2.0 * (a[0] * b[0] + a[3] * b[3]),
                2.0 * (a[3] * b[3] + a[1] * b[1]),
                2.0 * a[2] * b[2],
                (a[0] + a[1]) * b[3] + a[3] * (b[0] + b[1]),
            ]
        )
    return c


@ti.func
def determinant(a):
    """det a."""
    result = a[2] * (a[0] * a[1] - a[3] * a[3])
    if ti.static(a.n == 6):
        result += 2.0 * a[3] * a[4] * a[5] - a[0] * a[4] * a[4] - a[1] * a[5] * a[5]
    return result


@ti.func
def product_in_space(A, h):
    """A h in the space of A: rows of the dim × dim matrix A times the tensor h (out-of-plane entries do not enter)."""
    B = A
    if ti.static(A.n == 3):
        for i in ti.static(range(3)):
            B[i, 0] = A[i, 0] * h[0] + A[i, 1] * h[3] + A[i, 2] * h[5]
            B[i, 1] = A[i, 0] * h[3] + A[i, 1] * h[1] + A[i, 2] * h[4]
            B[i, 2] = A[i, 0] * h[5] + A[i, 1] * h[4] + A[i, 2] * h[2]
    else:
        for i in ti.static(range(2)):
            B[i, 0] = A[i, 0] * h[0] + A[i, 1] * h[3]
            B[i, 1] = A[i, 0] * h[3] + A[i, 1] * h[1]
    return B


@ti.func
def add_symmetric_part(h, C, A):
    """h + C + Cᵀ + C Aᵀ, where C Aᵀ + C + Cᵀ is symmetric."""
    result = h
    for k in ti.static(range(h.n)):
        i, j = ti.static(PAIRS[k])
        if ti.static(i < A.n and j < A.n):
            entry = h[k] + C[i, j] + C[j, i]
            for m in ti.static(range(A.n)):
                entry += C[i, m] * A[j, m]
            result[k] = entry
    return result
