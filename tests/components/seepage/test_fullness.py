"""How full space is, what moves it, and the pressure that keeps it from being too full."""

import numpy as np
import pytest
from scipy.optimize import minimize

from snowmpm.components.seepage.fullness import PEAK, REACH, Fullness, Grains, Walls, wendland
from snowmpm.components.seepage.projection import pressed

S = 0.1


def around(dim, jitter=0.2):
    """Places of water in a corner of two walls among grains, all `Fullness` takes, and the grains."""
    rng = np.random.default_rng(3)
    n = {2: 7, 3: 4}[dim]
    lattice = S * (np.stack(np.meshgrid(*[np.arange(n)] * dim, indexing="ij"), -1).reshape(-1, dim) + 0.5)
    walls = Walls([(axis, 0.0) for axis in range(dim)])
    half = lattice[lattice[:, 0] < S * n / 2]
    grains = Grains(half, np.full(len(half), S**dim), np.full(len(half), 0.4), walls, REACH * S)
    x = lattice + jitter * S * (rng.random(lattice.shape) - 0.5)
    return x, np.full(len(x), 0.4 * S**dim), grains, walls


@pytest.mark.parametrize("dim", [2, 3])
def test_gradients_are_those_of_fullness(dim):
    """G by central differences, at walls and in the middle."""
    x, volume, grains, walls = around(dim)
    full, step = Fullness(x, volume, grains, walls, REACH * S), 1e-6 * S
    for j in (0, len(x) // 2, len(x) - 1):
        for a in range(dim):
            f = []
            for way in (step, -step):
                moved = x.copy()
                moved[j, a] += way
                f.append(Fullness(moved, volume, grains, walls, REACH * S).f)
            np.testing.assert_allclose(full.gradients[a].toarray()[:, j], (f[0] - f[1]) / (2.0 * step), atol=1e-5 / S)


@pytest.mark.parametrize("dim", [2, 3])
def test_kernel_is_one(dim):
    """4 pi or 2 pi int W r^(dim-1) dr = 1."""
    r = (np.arange(20000) + 0.5) / 20000
    sphere = {2: 2.0 * np.pi, 3: 4.0 * np.pi}[dim]
    assert sphere * (wendland(r, 1.0, dim)[0] * r ** (dim - 1)).mean() == pytest.approx(1.0, abs=1e-7)
    assert wendland(0.0, 1.0, dim)[0] == PEAK[dim]
    slope = np.gradient(wendland(r, 1.0, dim)[0], r)
    np.testing.assert_allclose(wendland(r, 1.0, dim)[1][1:-1] * r[1:-1], -slope[1:-1], atol=1e-5)


def test_a_lattice_is_full():
    """Of grains and the water in their pores: f = 1 inside and at walls, to the error of the kernel's sum."""
    x, volume, grains, walls = around(2, jitter=0.0)
    full = Fullness(x, volume, grains, walls, REACH * S)
    inside = (x[:, 0] < 1.0 * S) & (x[:, 1] < 4.0 * S)
    assert inside.sum() == 4
    np.testing.assert_allclose(full.f[inside], 1.0, atol=0.02)
    np.testing.assert_allclose(full.share[inside], 0.4, atol=1e-12)
    np.testing.assert_allclose(full.medium[inside], 1.0, atol=0.02)


def test_pressure_against_bounded_minimum():
    """l >= 0 that minimises l A l / 2 - b l, by SciPy's L-BFGS-B, which knows nothing of who is pressed."""
    x, volume, grains, walls = around(2)
    full, rng = Fullness(x, volume, grains, walls, REACH * S), np.random.default_rng(1)
    n = len(x)
    answer, compliance, excess = np.full(n, 1e-2), np.full(n, 1e-2), rng.normal(size=n)
    found, _ = pressed(full.gradients, answer, compliance, excess, np.zeros(n))
    A = np.diag(compliance) + sum((G.multiply(answer) @ G.T).toarray() for G in full.gradients)
    best = minimize(lambda y: (0.5 * y @ A @ y - excess @ y, A @ y - excess), np.zeros(n), jac=True, method="L-BFGS-B",
                    bounds=[(0.0, None)] * n, options={"maxiter": 20000, "maxfun": 40000, "ftol": 1e-16, "gtol": 1e-10})
    assert (found > 0.0).any() and (found == 0.0).any()
    np.testing.assert_allclose(found, best.x, atol=2e-3 * best.x.max())
    left = excess - A @ found
    assert left.max() < 1e-3 and np.abs(left[found > 0.0]).max() < 1e-3
