"""What strength reduction divides: the strength of a law under a given pressure, by the factor."""

import numpy as np
import pytest

from snowmpm.errors import InputError
from snowmpm.materials import LAWS as LAWS_BY_KIND
from snowmpm.materials import (
    CohesiveCamClay,
    CohesiveCrack,
    CriticalStateHypoplastic,
    DruckerPrager,
    Elastic,
    Hypoplastic,
    ModifiedCamClay,
    MohrCoulomb,
    MuI,
    SolidToGas,
    StressUpdate,
    VonMises,
    WetSnow,
)
from snowmpm.materials.crack_planes import DAMAGE, OPENING
from snowmpm.strength.weakening import strengths, weakened

COMMON = {"density": 1850.0, "youngs_modulus": 3e7, "poisson_ratio": 0.3}
RATE = {**COMMON, "poisson_ratio": 0.0, "friction_angle": 32.0}
VOIDS = {"void_ratio": 0.7, "least_void_ratio": 0.5, "critical_void_ratio_limit": 0.55,
         "critical_void_ratio_drop": 0.25, "density_effect": 0.2}
SNOW = {**COMMON, "critical_slope": 1.2, "hardening": 1.0, "p0": 2e4}
COULOMB = MohrCoulomb(**COMMON, friction_angle=33.0, cohesion=9e3)
LAWS = [
    COULOMB, DruckerPrager(**COMMON, friction_angle=33.0, cohesion=9e3, cone="plane_strain"), VonMises(
        **COMMON, yield_stress=1e4), MuI(**COMMON, static_friction=0.4, limit_friction=0.7, grain_diameter=1e-3,
                                         grain_density=900.0),
    ModifiedCamClay(**SNOW), CohesiveCamClay(**SNOW, cohesion=0.3),
    WetSnow(**COMMON, friction_angle=33.0, cohesion=500.0, water_weakening=23.5), Hypoplastic(**RATE, cohesion=2e3),
    CriticalStateHypoplastic(**RATE, **VOIDS), SolidToGas(**RATE, **VOIDS, collision_time=8e-4),
    CohesiveCrack(**COMMON, strength=4e3, fracture_energy=5.0, friction_angle=30.0, shear_ratio=1.5),
]
CRACKED = {**COMMON, "strength": 4e3, "fracture_energy": 5.0, "friction_angle": 30.0, "shear_ratio": 1.5}
by_law = pytest.mark.parametrize("law", LAWS, ids=lambda law: law.kind)


def coulomb_line(law, pressure):
    """Shear stress on the plane of failure under a normal stress [Pa], from the law's own yield function: the least for
    which the circle that touches it there yields. The plane is that of `law.friction_angle`."""
    angle = np.radians(law.friction_angle)
    low, high = 0.0, 1e6
    for _ in range(60):
        tau = 0.5 * (low + high)
        # Mohr's circle through (pressure, tau) with its radius normal to the line there
        radius, middle = tau / np.cos(angle), pressure + tau * np.tan(angle)
        stress = -np.diag([middle + radius, middle, middle - radius])
        low, high = (low, tau) if law.yield_function(stress, np.zeros(3)) > 0.0 else (tau, high)
    return tau


def test_tangent_divides_the_shear_strength_under_any_pressure():
    for factor in (0.5, 1.3, 2.5):
        for pressure in (0.0, 1e4, 1e5):
            wanted = (9e3 + pressure * np.tan(np.radians(33.0))) / factor
            assert coulomb_line(weakened(COULOMB, factor), pressure) == pytest.approx(wanted, rel=1e-6)


def test_angle_divides_the_angle():
    law = weakened(COULOMB, 1.9, "angle")
    assert law.friction_angle == pytest.approx(33.0 / 1.9) and law.cohesion == pytest.approx(9e3 / 1.9)
    mu = weakened(LAWS[3], 1.5, "angle")
    assert np.arctan(mu.limit_friction) == pytest.approx(np.arctan(0.7) / 1.5)
    M = weakened(LAWS[4], 1.5, "angle").critical_slope
    assert np.arcsin(3.0 * M / (6.0 + M)) == pytest.approx(np.arcsin(3.6 / 7.2) / 1.5)


@by_law
@pytest.mark.parametrize("way", ["tangent", "angle"])
def test_a_law_keeps_all_else(law, way):
    same, less = weakened(law, 1.0, way), weakened(law, 1.25, way)
    for name, value in law.model_dump().items():
        kept = getattr(same, name)
        assert kept == value or kept == pytest.approx(value, rel=1e-12)
    reduced = strengths(less)
    assert reduced and all(reduced[name] < value or value == 0.0 for name, value in strengths(law).items())
    for name, value in law.model_dump().items():
        assert name in reduced or getattr(less, name) == value
    # from_run asks for the same density and stiffness
    assert (less.density, less.bulk_modulus, less.shear_modulus) == (law.density, law.bulk_modulus, law.shear_modulus)


@pytest.mark.parametrize("law", LAWS[4:6], ids=lambda law: law.kind)
def test_the_slope_of_an_ellipse_is_its_strength(law):
    """At each pressure the deviator on the yield surface is 1.3 times smaller."""
    p, state = np.linspace(1e3, 1.5e4, 5), np.array([law.initial_state()])

    def deviator(law):
        q = np.linspace(0.0, 5e4, 200_001)
        return np.array([q[np.argmax(law.yield_of_invariants(one, q, state) > 0.0)] for one in p])

    np.testing.assert_allclose(deviator(weakened(law, 1.3)), deviator(law) / 1.3, atol=0.5)


@pytest.mark.parametrize("way", ["tangent", "angle"])
@pytest.mark.parametrize("around", [
    {"kind": "drucker_prager", "friction_angle": 33.0, "dilation_angle": 20.0, "cohesion": 9e3},
    {"kind": "cohesive_cam_clay", "critical_slope": 1.2, "hardening": 1.0, "p0": 2e4, "cohesion": 0.3}],
    ids=lambda around: around["kind"])
def test_what_lies_around_cracks_is_weakened_with_them(around, way):
    """As it would be alone; the rest of the law of cracks as without it."""
    law, factor = CohesiveCrack(**CRACKED, bulk=around), 1.7
    less = weakened(law, factor, way)
    alone = LAWS_BY_KIND[around["kind"]](**COMMON, **{k: v for k, v in around.items() if k != "kind"})
    assert less.bulk.model_dump() == weakened(alone, factor, way).model_dump()
    assert less.model_copy(update={"bulk": None}) == weakened(CohesiveCrack(**CRACKED), factor, way)
    assert set(strengths(law)) == {"friction_angle", "strength", "fracture_energy"} | {
        f"bulk.{name}" for name in strengths(alone)}


def test_the_cohesion_of_a_crack_is_divided_at_every_jump():
    """T(u) of the law itself, drawn apart along one axis, elastic outside of the crack."""
    law = CohesiveCrack(**{**CRACKED, "poisson_ratio": 0.0}, length=0.05)
    opened = np.linspace(0.0, 1.2 * law.complete_opening, 300)

    def cohesion(one):
        """Traction [Pa] at these jumps."""
        strains = np.linspace(0.0, 2.0 * law.complete_opening / law.length, 4000)
        update = StressUpdate(one)
        path = update.integrate(np.zeros((1, 6)), update.initial_state(1),
                                (np.expm1(np.diff(strains))[:, None, None] * np.diag([1.0, 0.0, 0.0]))[None])
        jump = path.state[0, :, OPENING]
        cracked = path.state[0, :, DAMAGE] > 0.0
        return np.interp(opened[1:], jump[cracked], path.stress[0, cracked, 0])

    np.testing.assert_allclose(cohesion(weakened(law, 1.6)), cohesion(law) / 1.6, atol=2e-3 * law.strength)


def test_dilation_follows_friction_down():
    law = weakened(DruckerPrager(**COMMON, friction_angle=33.0, dilation_angle=20.0), 2.0)
    assert law.dilation_angle == law.friction_angle == pytest.approx(np.degrees(np.arctan(np.tan(np.radians(33)) / 2)))


def test_what_cannot_be():
    assert strengths(Elastic(**COMMON)) == {}
    with pytest.raises(InputError, match="hypoplastic with its strength divided by 9 is not possible") as found:
        weakened(LAWS[7], 9.0)
    assert str(found.value).count("\n") == 1
