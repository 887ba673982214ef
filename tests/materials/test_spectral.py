"""Spectral decomposition of a deviator: against LAPACK, at repeated and nearly repeated values, at any size."""

import functools

import numpy as np
import pytest
from parameter_sets import random_rotations

from snowmpm.compiler import ti
from snowmpm.materials import pack, unpack
from snowmpm.materials.precision import working_precision
from snowmpm.materials.spectral import compose, eigen_of_deviator
from snowmpm.materials.symmetric import contract, size


@functools.cache
def _kernel(dimension, precision):
    n = size(dimension)

    @ti.kernel
    def decompose(
        tensors: ti.types.ndarray(),
        values: ti.types.ndarray(),
        vectors: ti.types.ndarray(),
        composed: ti.types.ndarray(),
    ):
        for i in range(tensors.shape[0]):
            a = ti.Vector([tensors[i, k] for k in ti.static(range(n))])
            w, V = eigen_of_deviator(a, contract(a, a))
            back = compose(w, V, a)
            for k in ti.static(range(n)):
                composed[i, k] = back[k]
            for j in ti.static(range(3)):
                values[i, j] = w[j]
                for k in ti.static(range(3)):
                    vectors[i, j, k] = V[j, k]

    return decompose


def decomposed(tensors, dimension, precision):
    """Values, vectors and the tensor made of them again; and the tensors as they were given."""
    with working_precision(precision) as (_, dtype):
        packed = pack(tensors, dimension).astype(dtype)
        results = [np.zeros((len(packed), *shape), dtype) for shape in ((3,), (3, 3), (packed.shape[1],))]
        _kernel(dimension, precision)(packed, *results)
    values, vectors, composed = (r.astype(float) for r in results)
    return values, vectors, unpack(composed), unpack(packed.astype(float))


def deviators(dimension, rng):
    """Generic spectra, repeated ones of both kinds, gaps from 1e-1 to 1e-16, and axes that are coordinate axes."""
    n = 3000
    values = rng.normal(size=(n, 3))
    values[: n // 3, 1] = values[: n // 3, 0] + 10.0 ** rng.uniform(-16.0, -1.0, n // 3)
    values[: n // 6, 1] = values[: n // 6, 0]
    values -= values.mean(axis=1, keepdims=True)
    values *= 10.0 ** rng.uniform(-9.0, 1.0, (n, 1))
    Q = random_rotations(n, rng)
    if dimension == 2:
        angle = rng.uniform(0.0, 2.0 * np.pi, n)
        Q = np.tile(np.eye(3), (n, 1, 1))
        Q[:, 0, 0] = Q[:, 1, 1] = np.cos(angle)
        Q[:, 0, 1], Q[:, 1, 0] = -np.sin(angle), np.sin(angle)
    Q[::10] = np.eye(3)[rng.permutation(3)]
    return np.einsum("nij,nj,nkj->nik", Q, values, Q) if dimension == 3 else _plane(Q, values)


def _plane(Q, values):
    tensors = np.einsum("nij,nj,nkj->nik", Q, values, Q)
    tensors[:, :2, 2] = tensors[:, 2, :2] = 0.0
    return tensors


@pytest.mark.parametrize("precision", ["f32", "f64"])
@pytest.mark.parametrize("dimension", [2, 3])
def test_deviator_is_decomposed_to_round_off(dimension, precision):
    values, vectors, composed, given = decomposed(deviators(dimension, np.random.default_rng(3)), dimension, precision)
    eps = 6e-8 if precision == "f32" else 1.1e-16
    norm = np.linalg.norm(given, axis=(1, 2))[:, None]
    # A dozen operations on entries of the size of the tensor
    assert (np.abs(values - np.linalg.eigvalsh(given)[:, ::-1]) / norm).max() < 20 * eps
    assert (np.abs(composed - given).reshape(-1, 9) / norm).max() < 20 * eps
    identity = np.einsum("nij,nik->njk", vectors, vectors)
    assert np.abs(identity - np.eye(3)).max() < 20 * eps


@pytest.mark.parametrize("precision", ["f32", "f64"])
def test_nothing_is_decomposed_as_well(precision):
    tiny = np.array([np.zeros((3, 3)), 1e-25 * np.diag([1.0, 1.0, -2.0])])
    values, vectors, _, _ = decomposed(tiny, 3, precision)
    assert np.abs(values).max() < 1e-20
    np.testing.assert_allclose(np.einsum("nij,nik->njk", vectors, vectors), np.tile(np.eye(3), (2, 1, 1)), atol=1e-6)
