"""Logarithm, exponential and trial state against NumPy's eigen-decomposition, near the identity and far from it."""

import functools

import numpy as np
import pytest
from parameter_sets import random_rotations

from snowmpm.compiler import ti
from snowmpm.materials import pack, unpack
from snowmpm.materials.hencky import LOG_RADIUS, deviation_of_strain, hencky_strain, trial_deviation
from snowmpm.materials.precision import working_precision
from snowmpm.materials.spectral import eigen
from snowmpm.materials.symmetric import contract, size

EPS = {"f32": np.finfo(np.float32).eps, "f64": np.finfo(np.float64).eps}


@functools.cache
def kinematics_kernel(dimension, precision):
    n = size(dimension)

    @ti.kernel
    def evaluate(
        h: ti.types.ndarray(),
        A: ti.types.ndarray(),
        trial: ti.types.ndarray(),
        strain: ti.types.ndarray(),
        back: ti.types.ndarray(),
        values: ti.types.ndarray(),
        vectors: ti.types.ndarray(),
    ):
        for i in range(h.shape[0]):
            h_i = ti.Vector([h[i, k] for k in ti.static(range(n))])
            A_i = ti.Matrix.zero(float, dimension, dimension)
            for j, k in ti.static(ti.ndrange(dimension, dimension)):
                A_i[j, k] = A[i, j, k]
            h_i = trial_deviation(h_i, A_i)
            deviator, volume, deviator2, _ = hencky_strain(h_i)
            h_back = deviation_of_strain(deviator, volume, contract(deviator, deviator), 1.0)
            w, V = eigen(h_i)
            for k in ti.static(range(n)):
                trial[i, k] = h_i[k]
                strain[i, k] = deviator[k]
                back[i, k] = h_back[k]
            for j in ti.static(range(3)):
                strain[i, j] += volume / 3.0
                values[i, j] = w[j]
                for k in ti.static(range(3)):
                    vectors[i, j, k] = V[j, k]
            strain[i, n] = deviator2

    return evaluate


def evaluate(h, A, precision="f64"):
    """Trial tensor, Hencky strain, its exponential, eigenvalues, eigenvectors, e : e."""
    dimension = A.shape[-1]
    n, entries = len(h), size(dimension)
    with working_precision(precision) as (_, dtype):
        inputs = [np.ascontiguousarray(a, dtype) for a in (pack(h, dimension), A)]
        results = [np.zeros((n, *shape), dtype) for shape in ((entries,), (entries + 1,), (entries,), (3,), (3, 3))]
        kinematics_kernel(dimension, precision)(*inputs, *results)
    trial, strain, back, values, vectors = (r.astype(float) for r in results)
    return unpack(trial), unpack(strain[:, :-1]), unpack(back), values, vectors, strain[:, -1]


def tensors(n, size, rng, dimension=3):
    """Random symmetric tensors (n, 3, 3) with principal values up to `size`, block form in plane strain."""
    values = rng.uniform(-size, size, (n, 3))
    R = random_rotations(n, rng)
    if dimension == 2:
        angle = rng.uniform(0.0, 2.0 * np.pi, n)
        R = np.zeros((n, 3, 3))
        R[:, 0, 0] = R[:, 1, 1] = np.cos(angle)
        R[:, 0, 1], R[:, 1, 0], R[:, 2, 2] = -np.sin(angle), np.sin(angle), 1.0
    return np.einsum("nij,nj,nkj->nik", R, values, R)


def function_of(tensor, function):
    values, vectors = np.linalg.eigh(tensor)
    return np.einsum("nij,nj,nkj->nik", vectors, function(values), vectors)


def largest(tensor):
    return np.abs(tensor).max(axis=(1, 2))


def stored(strain, dimension, precision):
    """The tensors h of the given strains as the working precision stores them, and the Hencky strain of those."""
    h = pack(function_of(strain, lambda e: np.expm1(2.0 * e)), dimension)
    h = unpack(h.astype(np.float32).astype(float) if precision == "f32" else h)
    values = np.linalg.eigvalsh(h)
    # Entries of b carry round-off of the largest of them and of I: that is what an eigenvalue can be known to
    condition = np.maximum(1.0, 1.0 + values[:, 2]) / np.maximum(1.0 + values[:, 0], 1e-30)
    return h, function_of(h, lambda w: 0.5 * np.log1p(np.maximum(w, -1.0 + 1e-16))), condition


@pytest.mark.parametrize("precision", ["f32", "f64"])
@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("strain", [1e-8, 1e-6, 1e-3, 0.02, 0.1, 0.5])
def test_small_strains_keep_their_digits(strain, dimension, precision):
    n = 4000
    h, expected, _ = stored(tensors(n, strain, np.random.default_rng(3), dimension), dimension, precision)
    _, found, back, _, _, norm2 = evaluate(h, np.zeros((n, dimension, dimension)), precision)
    # Relative to the largest entry, whatever its size: measured 9 eps in float32, 24 in float64 (mostly NumPy's eigh)
    assert (largest(found - expected) / largest(expected)).max() < 40 * EPS[precision]
    assert (largest(back - h) / largest(h)).max() < 40 * EPS[precision]  # exp(2 ln) goes back; measured 16 eps
    deviator = expected - np.trace(expected, axis1=1, axis2=2)[:, None, None] / 3.0 * np.eye(3)
    # e : e is quadratic: twice the relative error of e, summed over nine entries
    scale = largest(expected) ** 2
    assert (np.abs(norm2 - np.einsum("nij,nij->n", deviator, deviator)) / scale).max() < 250 * EPS[precision]


@pytest.mark.parametrize("precision", ["f32", "f64"])
@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("strain", [2.0, 5.0])
def test_large_strains(strain, dimension, precision):
    n = 4000
    h, expected, condition = stored(tensors(n, strain, np.random.default_rng(4), dimension), dimension, precision)
    _, found, back, _, _, _ = evaluate(h, np.zeros((n, dimension, dimension)), precision)
    assert np.isfinite(found).all() and np.isfinite(back).all()
    known = condition * EPS[precision] < 0.01  # beyond that the stored tensor no longer holds its smallest eigenvalue
    assert known.mean() > (0.3 if (precision, strain) == ("f32", 5.0) else 0.999)
    assert (largest(found - expected) / (condition * EPS[precision]))[known].max() < 30
    assert (largest(back - h) / (largest(h) * EPS[precision]))[known].max() < 300  # measured 210: squarings


def test_series_meets_spectral_path_without_a_step():
    # Deviators just inside and just outside the radius of the series
    rng = np.random.default_rng(5)
    for precision, radius in zip(("f32", "f64"), LOG_RADIUS, strict=True):
        deviator = tensors(2000, 1.0, rng)
        deviator -= np.trace(deviator, axis1=1, axis2=2)[:, None, None] / 3.0 * np.eye(3)
        deviator /= np.linalg.norm(deviator, axis=(1, 2))[:, None, None]
        for factor in (0.999, 1.001):
            h = radius * factor * deviator
            values, vectors = np.linalg.eigh(h)
            expected = np.einsum("nij,nj,nkj->nik", vectors, 0.5 * np.log1p(values), vectors)
            found = evaluate(h, np.zeros((2000, 3, 3)), precision)[1]
            assert (largest(found - expected) / largest(expected)).max() < 40 * EPS[precision]


@pytest.mark.parametrize("precision", ["f32", "f64"])
@pytest.mark.parametrize(
    "values",
    [(0.0, 0.0, 0.0), (3.0, 3.0, 3.0), (3.0, 3.0, 1.0), (3.0, 3.0 + 1e-9, 1.0), (2.0, 1e-9, 0.0), (1e6, 1.0, 1e-6)],
    ids=["zero", "isotropic", "double", "gap 1e-9", "gap 1e-9 at zero", "graded"],
)
def test_eigen_decomposition_of_awkward_spectra(values, precision):
    R = random_rotations(500, np.random.default_rng(6))
    h = np.einsum("nij,j,nkj->nik", R, values, R)
    h[0] = np.diag(values)  # already diagonal
    found, vectors = evaluate(h, np.zeros((500, 3, 3)), precision)[3:5]
    eps = EPS[precision]
    assert np.abs(np.einsum("nij,nik->njk", vectors, vectors) - np.eye(3)).max() < 10 * eps
    # Backward stable: V w Vᵀ gives the tensor back to round-off of its largest entry
    rebuilt = np.einsum("nij,nj,nkj->nik", vectors, found, vectors)
    assert np.abs(rebuilt - h).max() <= 20 * eps * max(values)


@pytest.mark.parametrize("dimension", [2, 3])
def test_trial_state_is_f_b_ft(dimension):
    n, rng = 1000, np.random.default_rng(7)
    h = function_of(tensors(n, 0.3, rng, dimension), lambda e: np.expm1(2.0 * e))
    A = 0.3 * rng.normal(size=(n, dimension, dimension))
    f = np.tile(np.eye(3), (n, 1, 1))
    f[:, :dimension, :dimension] += A
    expected = f @ (np.eye(3) + h) @ f.transpose(0, 2, 1) - np.eye(3)
    np.testing.assert_allclose(evaluate(h, A)[0], expected, atol=1e-14 * largest(expected).max())


def test_float32_turns_a_small_strain_without_loss():
    # A strain of 1e-5 turned by 20 rad in 20 000 steps: with b in place of h, float32 is off by a factor of 30
    steps, angle = 20_000, 1e-3
    spin = np.array([[[0.0, -angle], [angle, 0.0]]])
    A = spin + 0.5 * spin @ spin
    h = np.diag([2e-5, -1e-5, 1e-5])[None]
    volume = 0.5 * np.log1p(np.diagonal(h[0])).sum()
    with working_precision("f32"):
        kernel = kinematics_kernel(2, "f32")
        state = pack(h, 2).astype(np.float32)
        results = [np.zeros((1, *shape), np.float32) for shape in ((4,), (5,), (4,), (3,), (3, 3))]
        for _ in range(steps):
            kernel(state, A.astype(np.float32), *results)
            state = results[0].copy()
    strain = results[1][0]
    # The spin itself is only exact to θ⁴/8 a step: det f grows by 2.5e-9 in all
    assert abs(strain[:3].sum() / volume - 1.0) < 2e-3
