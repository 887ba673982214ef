"""Neo-Hookean and St. Venant-Kirchhoff elasticity against closed forms, their energy against the work of the stress.

St. Venant and Kirchhoff's stress is found here from S = lambda tr(E) I + 2 mu E of the deformation gradient, and that
of Simo and Hughes by J and dev b (section 9.2.1), apart from the forms in which the laws compute.
"""

import numpy as np
import pytest

from snowmpm.materials import NeoHookean, StressUpdate, StVenantKirchhoff, pack, unpack

SNOW = {"density": 250.0, "youngs_modulus": 3e6, "poisson_ratio": 0.3}
LAWS = [NeoHookean(**SNOW), StVenantKirchhoff(**SNOW)]
BULK, SHEAR = LAWS[0].bulk_modulus, LAWS[0].shear_modulus
LAME = BULK - 2.0 / 3.0 * SHEAR
EYE = np.eye(3)


def expected(law, F):
    """tau (n, 3, 3) of deformation gradients (n, 3, 3)."""
    Ft = F.transpose(0, 2, 1)
    if law.kind == "st_venant_kirchhoff":
        E = 0.5 * (Ft @ F - EYE)
        S = LAME * np.trace(E, axis1=1, axis2=2)[:, None, None] * EYE + 2.0 * SHEAR * E
        return F @ S @ Ft
    b, J = F @ Ft, np.linalg.det(F)[:, None, None]
    deviator = b - np.trace(b, axis1=1, axis2=2)[:, None, None] / 3.0 * EYE
    return SHEAR * J ** (-2.0 / 3.0) * deviator + 0.5 * BULK * (J**2 - 1.0) * EYE


def found(law, F):
    """The same in one step from rest."""
    update = StressUpdate(law)
    return update(np.zeros((len(F), 6)), update.initial_state(len(F)), F - EYE, 1.0)


def gradients(size, n=200):
    """Deformation gradients that turn, and deform by about `size`."""
    rng = np.random.default_rng(2)
    turn = np.linalg.qr(rng.normal(size=(n, 3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))[:, None, None]
    return turn @ (EYE + size * rng.uniform(-1.0, 1.0, (n, 3, 3)))


@pytest.mark.parametrize("law", LAWS, ids=lambda law: law.kind)
def test_stress_is_that_of_its_energy(law):
    for size in (1e-6, 0.02, 0.15):
        F = gradients(size)
        stress, exact = unpack(found(law, F).stress), expected(law, F)
        # A step that turns rounds strains of 1e-6 to 1e-10
        np.testing.assert_allclose(stress, exact, rtol=0, atol=max(1e-9, 2e-15 / size) * np.abs(exact).max())


@pytest.mark.parametrize("law", LAWS, ids=lambda law: law.kind)
def test_uniaxial_strain_and_simple_shear(law):
    s = np.array([0.7, 0.95, 1.0, 1.1, 1.4])
    F = np.tile(EYE, (5, 1, 1))
    F[:, 0, 0] = s
    axial = found(law, F).stress[:, 0]
    if law.kind == "neo_hookean":
        exact = 2.0 / 3.0 * SHEAR * s ** (-2.0 / 3.0) * (s**2 - 1.0) + 0.5 * BULK * (s**2 - 1.0)
    else:
        exact = 0.5 * (LAME + 2.0 * SHEAR) * s**2 * (s**2 - 1.0)
    np.testing.assert_allclose(axial, exact, rtol=1e-12, atol=1e-9)
    k = np.array([0.01, 0.5, 2.0])
    F = np.tile(EYE, (3, 1, 1))
    F[:, 0, 1] = k
    tau = unpack(found(law, F).stress)
    shear = SHEAR * k if law.kind == "neo_hookean" else (0.5 * LAME + SHEAR) * k**3 + SHEAR * k
    np.testing.assert_allclose(tau[:, 0, 1], shear, rtol=1e-12)
    # Poynting's effect: the difference of normal stresses is k times the shear stress
    np.testing.assert_allclose(tau[:, 0, 0] - tau[:, 1, 1], k * shear, rtol=1e-9)


@pytest.mark.parametrize("law", LAWS, ids=lambda law: law.kind)
def test_energy_is_the_work_done(law):
    """Against the power tau : L summed over a way from rest, by Gauss's rule; the strain comes back from the stress."""
    for size in (1e-5, 0.1):
        H = size * np.random.default_rng(4).uniform(-1.0, 1.0, (40, 3, 3))
        place, weight = np.polynomial.legendre.leggauss(12)
        work = sum(0.5 * w * np.einsum("nij,nij->n", expected(law, EYE + 0.5 * (1.0 + t) * H), np.einsum(
            "nij,njk->nik", H, np.linalg.inv(EYE + 0.5 * (1.0 + t) * H))) for t, w in zip(place, weight, strict=True))
        stress = expected(law, EYE + H)
        energy = law.elastic_energy(pack(stress), np.zeros((40, 0)))
        np.testing.assert_allclose(energy, work, rtol=1e-5 if size < 1e-3 else 1e-9)
        b = (EYE + H) @ (EYE + H).transpose(0, 2, 1)
        back = law.hencky_from_stress(stress)
        values, axes = np.linalg.eigh(b)
        strain = np.einsum("nik,nk,njk->nij", axes, 0.5 * np.log(values), axes)
        np.testing.assert_allclose(back, strain, rtol=0, atol=1e-9 * np.abs(strain).max() + 1e-14)


def test_no_strain_beyond_the_fold():
    """St. Venant and Kirchhoff's stress has a least value in compression: below it there is no strain."""
    law = StVenantKirchhoff(density=250.0, youngs_modulus=1e6, poisson_ratio=0.0)
    least = -1e6 / 8.0  # of mu b h with mu = E / 2, at b = 1/2
    assert np.isnan(law.hencky_from_stress(np.diag([1.1 * least, 0.0, 0.0]))).any()
    assert np.isfinite(law.hencky_from_stress(np.diag([0.9 * least, 0.0, 0.0]))).all()


@pytest.mark.parametrize("precision", ["f32", "f64"])
def test_a_pack_grows_as_one_by_one(precision):
    """exp(2 ln J) in a straight line, as far as that goes: ln J = -0.24 was off by 1e-11 in f64 and 1e-6 in f32."""
    law = NeoHookean(density=300.0, youngs_modulus=1e6, poisson_ratio=0.3)
    A = np.expm1(np.linspace(-0.08, 0.06, 141))[:, None, None] * np.eye(3)
    h, state = np.zeros((len(A), 6)), StressUpdate(law, 3, precision).initial_state(len(A))
    packed, alone = (StressUpdate(law, 3, precision, packed=packed)(h, state, A, 1e-3) for packed in (True, False))
    size = np.abs(alone.stress).max(axis=1) + 1e-3 * law.bulk_modulus
    assert (np.abs(packed.stress - alone.stress).max(axis=1) / size).max() < (2e-14 if precision == "f64" else 1e-6)
