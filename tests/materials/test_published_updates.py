"""Algorithms 1 and 2 of the SPH literature, hypoelastic with Jaumann's rate, beside the return map of this program."""

import numpy as np
import pytest

from snowmpm.materials import DruckerPrager, MaterialPoint
from tests.support.published_updates import algorithm_1, algorithm_2, excess, follow

SAND = DruckerPrager(density=1800.0, youngs_modulus=2e7, poisson_ratio=0.3, friction_angle=30.0)
PRESSURE = 1e4
START = -PRESSURE * np.eye(3)
by_algorithm = pytest.mark.parametrize("algorithm", [algorithm_1, algorithm_2])


def shear(rate=1.0):
    """Velocity gradient of simple shear at constant volume."""
    L = np.zeros((3, 3))
    L[0, 2] = rate
    return L


def returned(steps, shear_strain):
    """Cauchy stress of the law itself along the same simple shear, which keeps the volume."""
    F = np.tile(np.eye(3), (steps, 1, 1))
    F[:, 0, 2] = shear_strain * np.linspace(0.0, 1.0, steps + 1)[1:]
    return MaterialPoint(SAND).drive(F, stress=START).kirchhoff


@by_algorithm
def test_turning_without_stretching_turns_the_stress(algorithm):
    """The sign of the spin; an explicit step lengthens the deviator by 2 θ² of its turn θ."""
    stress = np.diag([-2e4, -1.5e4, -1e4])
    L = np.array([[0.0, 0.0, -0.5 * np.pi], [0.0, 0.0, 0.0], [0.5 * np.pi, 0.0, 0.0]])
    end = follow(algorithm, SAND, stress, L, 1000)[-1]  # by a quarter: x takes the place of z
    np.testing.assert_allclose(end, np.diag([-1e4, -1.5e4, -2e4]), atol=30.0)


def test_shear_stress_of_the_hypoelastic_law_swings():
    """Without yielding σ_xz = G sin γ (Dienes 1979, doi:10.1007/BF01379008), which falls beyond γ = π/2. On Hencky
    strains it is 2 G asinh(γ/2) / sqrt(1 + γ²/4), which grows until γ = 3.02."""
    strong, steps = SAND.model_copy(update={"cohesion": 1e12}), 4000
    gamma = 3.0 * np.linspace(0.0, 1.0, steps + 1)[1:]
    path = follow(algorithm_2, strong, 0.0 * START, shear(3.0), steps)
    np.testing.assert_allclose(path[:, 0, 2] / strong.shear_modulus, np.sin(gamma), atol=3e-3)
    F = np.tile(np.eye(3), (300, 1, 1))
    F[:, 0, 2] = np.linspace(0.01, 3.0, 300)
    half = 0.5 * F[:, 0, 2]
    hencky = MaterialPoint(strong).drive(F).kirchhoff[:, 0, 2] / strong.shear_modulus
    np.testing.assert_allclose(hencky, 2.0 * np.arcsinh(half) / np.sqrt(1.0 + half**2), rtol=1e-6)
    assert (np.diff(hencky) > 0.0).all() and path[-1, 0, 2] < 0.2 * strong.shear_modulus


@pytest.mark.parametrize("steps", [50, 200, 800, 3200])
def test_algorithm_1_keeps_what_it_overshoots(steps):
    """The step in which yielding begins is elastic; what it goes beyond the surface, at most √3 G Δγ, stays."""
    path = follow(algorithm_1, SAND, START, shear(0.2), steps)
    off = np.array([excess(SAND, sigma) for sigma in path])
    most = np.sqrt(3.0) * SAND.shear_modulus * 0.2 / steps
    assert 0.0 < off[-1] <= most
    assert off[-1] == pytest.approx(off.max(), rel=1e-2)


def test_algorithm_2_is_the_return_map_to_first_order_of_the_step():
    """On a cone one correction is exact, and elastic strains of a thousandth leave nothing else to differ."""
    found = []
    for steps in (100, 200, 400):
        path, own = follow(algorithm_2, SAND, START, shear(0.2), steps), returned(steps, 0.2)
        assert max(abs(excess(SAND, sigma)) for sigma in path[steps // 2:]) < 1e-12 * PRESSURE
        found.append(np.abs(path[-1] - own[-1]).max() / PRESSURE)
    assert found[0] < 1e-3
    np.testing.assert_allclose(np.divide(found[:-1], found[1:]), 2.0, rtol=0.05)
