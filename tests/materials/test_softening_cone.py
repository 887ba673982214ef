"""The cone whose friction, cohesion and dilation fade, against its published rate equations (R7)."""

import numpy as np
import pytest
from pydantic import ValidationError
from scipy.integrate import solve_ivp

from snowmpm.materials import DruckerPrager, LoadingStage, MixedControl, SofteningCone, StressUpdate, pack

SOIL = {"density": 1800.0, "youngs_modulus": 2e7, "poisson_ratio": 0.3}
LAWS = {
    "sand": SofteningCone(**SOIL, friction_angle=38.0, residual_friction_angle=31.0, dilation_angle=10.0,
                          softening_strain=0.03, dilation_strain=0.05),
    "clay": SofteningCone(**SOIL, friction_angle=25.0, residual_friction_angle=15.0, dilation_angle=4.0,
                          cohesion=2e4, residual_cohesion=1e3, softening_strain=0.05),
}
by_law = pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)


def published(law, pressure, strains):
    """q and plastic strain of drained triaxial compression at the axial strains, by eqs. 69-82 of [B] in the rate
    form, small strains: multiplier (f_σ : C : dε) / (f_σ : C : g_σ − f_κ √(2/3 g:g)), its softening term negative as
    consistency has it. Triaxial compression: α(φ) and α_ψ(ψ) of the outer corners."""
    K, G, rise = law.bulk_modulus, law.shear_modulus, 1e-6

    def cone(kappa):
        fade = np.exp(-kappa / law.softening_strain)
        phi = np.radians(law.residual_friction_angle + (law.friction_angle - law.residual_friction_angle) * fade)
        c = law.residual_cohesion + (law.cohesion - law.residual_cohesion) * fade
        psi = np.radians(law.dilation_angle * np.exp(-kappa / (law.dilation_strain or np.inf)))
        s, t = np.sin(phi), np.sin(psi)
        return 6 * s / (3 - s), 6 * c * np.cos(phi) / (3 - s), 6 * t / (3 - t)

    def rates(y, lateral, yields):
        """Of p, q and κ at an axial strain rate of 1, compression positive."""
        p, _, kappa = y
        volume, shear, flow = 1.0 + 2.0 * lateral, 2.0 / 3.0 * (1.0 - lateral), 0.0
        alpha, k, psi = cone(kappa)
        if yields:
            later = cone(kappa + rise)
            falls = ((later[0] - alpha) * p + later[1] - k) / rise
            flow = (3.0 * G * shear - alpha * K * volume) / (3.0 * G + K * alpha * psi + falls)
        return np.array([K * (volume + psi * flow), 3.0 * G * (shear - flow), flow])

    def slope(_, y):
        alpha, k, _ = cone(y[2])
        yields = y[1] > alpha * y[0] + k - 1e-9 * y[0]
        # The lateral rate that keeps σ3 = p − q/3, in which both branches are linear
        one, other = (rates(y, lateral, yields) for lateral in (0.0, -1.0))
        miss = [rate[0] - rate[1] / 3.0 for rate in (one, other)]
        return rates(y, -miss[0] / (miss[0] - miss[1]), yields)

    found = solve_ivp(slope, (0.0, strains[-1]), [pressure, 0.0, 0.0], t_eval=strains, max_step=strains[-1] / 300,
                      rtol=1e-7, atol=1e-9)  # fmt: skip
    return found.y[1], found.y[2]


@by_law
def test_drained_triaxial_compression(law):
    """Peak and fall to the residual strength. First order in the step of the law, and strains are small."""
    strains = np.array([0.01, 0.02, 0.05, 0.1])
    q, kappa = published(law, 1e5, strains)
    control, errors = MixedControl(law), []
    for steps in (50, 100):
        stages = [LoadingStage({"zz": -e}, {"xx": -1e5, "yy": -1e5}, steps) for e in strains]
        rows = control.follow_stages(stages, control.consolidated(1e5))[steps - 1 :: steps]
        found = np.array([row.cauchy[0] - row.cauchy[2] for row in rows])
        errors.append(np.abs(found - q).max() / q.max())
        plastic = np.array([row.state[0] for row in rows])
    assert errors[1] < 0.02 and errors[1] < errors[0] + 1e-3
    np.testing.assert_allclose(plastic, kappa, rtol=0.03, atol=2e-4)
    assert plastic[-1] > law.softening_strain and q.max() > 1.2 * q[-1]  # past its peak


@pytest.mark.parametrize("left", [5e3, 1e3], ids=["keeps its cohesion", "loses cohesion"])
def test_with_one_friction_angle_it_is_drucker_prager(left):
    numbers = {**SOIL, "friction_angle": 33.0, "dilation_angle": 7.0, "cohesion": 5e3, "residual_cohesion": left,
               "softening_strain": 0.02}
    for cone in ("triaxial_compression", "triaxial_extension", "plane_strain"):
        plain = DruckerPrager(**numbers, cone=cone)
        fading = SofteningCone(**numbers, cone=cone, residual_friction_angle=33.0)
        rng = np.random.default_rng(3)
        A = 3e-3 * rng.standard_normal((200, 3, 3)) - 1e-3 * np.eye(3)
        h = np.tile(pack(plain.h_from_stress(-3e4 * np.eye(3))), (200, 1))
        found, wanted = (StressUpdate(law, packed=False)(h, StressUpdate(law).initial_state(200), A)
                         for law in (fading, plain))  # fmt: skip
        np.testing.assert_allclose(found.stress, wanted.stress, atol=1e-6 * 3e4)
        np.testing.assert_allclose(found.state, wanted.state, atol=1e-10)
        assert (found.iterations > 0).any() and (found.state[:, 1] == 0.0).all()


@by_law
def test_the_end_is_the_residual_strength(law):
    strain = np.array([0.0, 20.0 * law.softening_strain])
    np.testing.assert_allclose(law.friction_at(strain), [law.friction_angle, law.residual_friction_angle])
    residual = DruckerPrager(**SOIL, friction_angle=law.residual_friction_angle, cohesion=law.residual_cohesion)
    end = law.model_copy(update={"dilation_angle": 0.0})
    assert end.alpha_at(strain)[1] == pytest.approx(residual.alpha)
    assert end.k_at(strain)[1] == pytest.approx(residual.k, abs=1e-9)


@pytest.mark.parametrize(("change", "word"), [
    ({"residual_friction_angle": 39.0}, "residual_friction_angle"), ({"dilation_strain": 10.0}, None),
    ({"dilation_angle": 32.0, "dilation_strain": None}, "dilation_angle"),
    ({"residual_friction_angle": 0.0}, "residual_cohesion"), ({"residual_cohesion": 10.0}, "residual_cohesion"),
])
def test_numbers_that_make_no_sense(change, word):
    table = {**LAWS["sand"].model_dump(), **change}
    if word is None:
        assert SofteningCone.model_validate(table)
        return
    with pytest.raises(ValidationError, match=word):
        SofteningCone.model_validate(table)
