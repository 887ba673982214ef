"""Tangents of a step (I1): against differences of the laws outside any solver, and against the exact one of Hencky."""

import numpy as np
import pytest

from snowmpm.implicit.response import Before, respond
from snowmpm.materials import (
    AnticrackCamClay,
    CohesiveCamClay,
    DruckerPrager,
    Elastic,
    ModifiedCamClay,
    MohrCoulomb,
    NeoHookean,
    StressUpdate,
    StVenantKirchhoff,
    VonMises,
    unpack,
)
from snowmpm.particles.material_table import MaterialTable

SOIL = {"density": 1500.0, "youngs_modulus": 1e7, "poisson_ratio": 0.3}
SNOW = {"density": 250.0, "poisson_ratio": 0.3}
LAWS = {
    "elastic": Elastic(**SNOW, youngs_modulus=3e6),
    "neo-Hookean": NeoHookean(**SNOW, youngs_modulus=3e6),
    "St. Venant-Kirchhoff": StVenantKirchhoff(**SNOW, youngs_modulus=3e6),
    "von Mises": VonMises(**SOIL, yield_stress=2e4, hardening_modulus=3e6),
    "perfectly plastic": VonMises(**SOIL, yield_stress=2e4),
    "Drucker-Prager": DruckerPrager(**SOIL, friction_angle=30.0, dilation_angle=10.0, cohesion=1e4),
    "Mohr-Coulomb": MohrCoulomb(**SOIL, friction_angle=30.0, dilation_angle=10.0, cohesion=1e4),
    "modified Cam-Clay": ModifiedCamClay(**SNOW, youngs_modulus=3e6, critical_slope=0.5, hardening=1.0, p0=3e3),
    "cohesive Cam-Clay": CohesiveCamClay(**SNOW, youngs_modulus=3e6, critical_slope=1.5, cohesion=0.3, hardening=1.0,
                                         p0=3e4),
    "weak layer": AnticrackCamClay(density=100.0, youngs_modulus=5e5, poisson_ratio=0.3, critical_slope=1.0,
                                   cohesion=0.3, hardening=0.1, p0=4.5e3, softening=2.0),
}
N = 400


def states(law, dim, size):
    """h, state of N particles after a random step, and the A of the next one, of about `size`."""
    rng, update = np.random.default_rng(5), StressUpdate(law, dim, "f64", packed=False)
    squeeze = rng.uniform(-2.0 * size, 0.0, N)[:, None, None] * np.eye(dim)
    squeeze += 0.3 * size * rng.normal(size=(N, dim, dim))
    before = update(np.zeros((N, 4 if dim == 2 else 6)), update.initial_state(N), squeeze)
    return before.h, before.state, size * rng.normal(size=(N, dim, dim))


def pushed(update, h, state, A):
    """P = tau f^-T, (n, dim, dim), and the iterations of the law."""
    dim, found = A.shape[1], update(h, state, A, 1.0)
    tau = unpack(found.stress)[:, :dim, :dim]
    return tau @ np.linalg.inv(np.eye(dim) + A).transpose(0, 2, 1), found.iterations


def differences(update, h, state, A, step):
    """C by central differences."""
    dim = A.shape[1]
    C = np.empty((len(A), dim, dim, dim, dim))
    for k in range(dim):
        for l in range(dim):
            one = np.zeros((dim, dim))
            one[k, l] = step
            C[..., k, l] = (pushed(update, h, state, A + one)[0] - pushed(update, h, state, A - one)[0]) / (2.0 * step)
    return C


@pytest.mark.parametrize(("name", "dim"), [
    *((name, 2) for name in LAWS),
    *(pytest.param(name, 3, marks=() if name == "von Mises" else pytest.mark.slow) for name in LAWS)])
def test_tangent_is_that_of_the_law(name, dim):
    """To 1e-6 where the law is smooth: two differences of other steps, of which the error is known, agree there."""
    law = LAWS[name]
    size = 0.1 if not law.YIELDS else {"weak layer": 0.005}.get(name, 0.003)
    h, state, A = states(law, dim, size)
    update = StressUpdate(law, dim, "f64", packed=False)
    coarse, fine = (differences(update, h, state, A, step * size) for step in (4e-3, 2e-3))
    reference = (4.0 * fine - coarse) / 3.0
    scale = np.abs(reference).max(axis=(1, 2, 3, 4))
    P, iterations = pushed(update, h, state, A)
    smooth = np.abs(fine - coarse).max(axis=(1, 2, 3, 4)) < 1e-4 * scale
    assert smooth.mean() > 0.8  # the others are at an edge of their law
    if law.YIELDS:
        assert (smooth & (iterations > 0)).mean() > 0.2
    after = respond(MaterialTable([law], "f64"), Before(h, state, np.ones(N), np.zeros(N, np.int32)), A, 1.0, True)
    np.testing.assert_allclose(after.P, P, rtol=0, atol=1e-9 * np.abs(P).max())
    off = np.abs(after.C - reference).max(axis=(1, 2, 3, 4))
    assert (off <= 1e-6 * scale)[smooth].all()


def exact_hencky(law, h, A):
    """C of Hencky elasticity from the derivative of the logarithm in the axes of b (n, 3, 3, 3, 3)."""
    eye = np.eye(3)
    f = eye + A
    b = f @ (eye + unpack(h)) @ f.transpose(0, 2, 1)
    values, axes = np.linalg.eigh(b)
    logs = 0.5 * np.log(values)
    gap = values[:, :, None] - values[:, None, :]
    near = np.abs(gap) < 1e-9
    slope = np.where(near, 0.5 / values[:, :, None], (logs[:, :, None] - logs[:, None, :]) / np.where(near, 1.0, gap))
    strain = np.einsum("nia,na,nja->nij", axes, logs, axes)
    lame, mu = law.bulk_modulus - 2.0 / 3.0 * law.shear_modulus, law.shear_modulus
    tau = lame * np.trace(strain, axis1=1, axis2=2)[:, None, None] * eye + 2.0 * mu * strain
    back = np.linalg.inv(f)
    C = np.empty((len(A), 3, 3, 3, 3))
    for k in range(3):
        for l in range(3):
            df = np.zeros((3, 3))
            df[k, l] = 1.0
            half = df @ (eye + unpack(h)) @ f.transpose(0, 2, 1)
            db = half + half.transpose(0, 2, 1)
            de = axes @ (slope * (axes.transpose(0, 2, 1) @ db @ axes)) @ axes.transpose(0, 2, 1)
            dtau = lame * np.trace(de, axis1=1, axis2=2)[:, None, None] * eye + 2.0 * mu * de
            dback = -back @ df @ back
            C[..., k, l] = dtau @ back.transpose(0, 2, 1) + tau @ dback.transpose(0, 2, 1)
    return C


def test_tangent_of_hencky_is_exact():
    law = LAWS["elastic"]
    h, state, A = states(law, 3, 0.15)
    after = respond(MaterialTable([law], "f64"), Before(h, state, np.ones(N), np.zeros(N, np.int32)), A, 1.0, True)
    exact = exact_hencky(law, h, A)
    scale = np.abs(exact).max(axis=(1, 2, 3, 4), keepdims=True)
    assert np.abs((after.C - exact) / scale).max() < 1e-6
