"""Cone matching, converters, and the page that explains them: every number on it is computed again."""

import re
from pathlib import Path

import numpy as np
import pytest
from frictional_laws import SOIL
from parameter_sets import A, changed, diagonal

import snowmpm.materials
from snowmpm.materials import CohesiveCamClay, DruckerPrager, MaterialPoint, MohrCoulomb, cone, conventions

PAGE = (Path(snowmpm.materials.__file__).parent / "CONVENTIONS.md").read_text(encoding="utf-8")
WORKED = re.findall(r"`([a-z_0-9]+\([^`]*\))` = ([-0-9., ]+[0-9])", PAGE)
CONVERTERS = {name: thing for name, thing in vars(conventions).items() if callable(thing) and not name.startswith("_")}
IMPORTED = {"cone_slope", "cone_friction_angle"}


@pytest.mark.parametrize(("call", "numbers"), WORKED, ids=[call for call, _ in WORKED])
def test_worked_number(call, numbers):
    printed = numbers.split(", ")
    found = np.atleast_1d(eval(call, {"__builtins__": {}}, CONVERTERS))
    assert len(printed) == len(found)
    for text, value in zip(printed, found, strict=True):
        digits = len(text.strip("-").replace(".", "").lstrip("0"))
        # as many digits as are printed; inputs have seven
        assert value == pytest.approx(float(text), rel=max(0.51 * 10.0 ** (1 - digits), 2e-7), abs=1e-12)


def test_every_converter_is_on_the_page():
    assert {call.split("(")[0] for call, _ in WORKED} == set(CONVERTERS) - IMPORTED


def test_slopes_of_37_degrees():
    # the printed four digits of the three matchings, both limits of the third
    found = [cone.cone_slope(37.0, name) for name in cone.CONES] + [cone.cone_slope(37.0, "plane_strain", 37.0)]
    np.testing.assert_allclose(found, [1.5057, 1.0025, 1.0424, 0.9846], atol=5e-5)
    s, t = np.sin(np.radians(37.0)), np.tan(np.radians(37.0))
    exact = [6 * s / (3 - s), 6 * s / (3 + s), np.sqrt(3) * s, 3 * np.sqrt(3) * t / np.sqrt(9 + 12 * t**2)]
    np.testing.assert_allclose(found, exact, rtol=1e-14)
    assert cone.dilation_slope(37.0, "plane_strain") == pytest.approx(exact[3], rel=1e-14)


@pytest.mark.parametrize("name", cone.CONES)
@pytest.mark.parametrize("psi", [0.0, 10.0, 25.0])
def test_angle_and_slope_are_inverse(name, psi):
    angle = np.linspace(0.0, 89.0, 60)
    slope = cone.cone_slope(angle, name, psi)
    np.testing.assert_allclose(cone.cone_friction_angle(slope, name, psi), angle, atol=1e-9)  # flat near 90 degrees
    assert (np.diff(slope) > 0.0).all()
    c, phi = conventions.coulomb_of_drucker_prager(
        *conventions.drucker_prager_of_coulomb(7e3, 33.0, name, psi), name, psi
    )
    assert (c, phi) == (pytest.approx(7e3, rel=1e-13), pytest.approx(33.0, rel=1e-13))


def test_slopes_beyond_any_angle_are_refused():
    for name, slope in (("triaxial_compression", 3.01), ("triaxial_extension", 1.51), ("plane_strain", 1.74)):
        with pytest.raises(ValueError, match=name):
            cone.cone_friction_angle(slope, name)


@pytest.mark.parametrize("name", cone.CONES)
def test_cone_touches_the_hexagon_where_it_says(name):
    # Stresses of each kind at yield of Mohr-Coulomb: on the matched cone
    hexagon = MohrCoulomb(**SOIL, friction_angle=33.0, cohesion=4e3)
    circle = DruckerPrager(**SOIL, friction_angle=33.0, cohesion=4e3, cone=name)
    s, c = np.sin(np.radians(33.0)), np.cos(np.radians(33.0))
    least = np.array([-2e3, 0.0, 1e4, 1e6])
    most = (least * (1.0 + s) + 2.0 * 4e3 * c) / (1.0 - s)
    middle = {"triaxial_compression": least, "triaxial_extension": most, "plane_strain": (least + most) / 2.0}[name]
    stress = -np.stack([most, middle, least], axis=-1)[:, None] * np.eye(3)
    state = np.zeros((4, 2))
    np.testing.assert_allclose(hexagon.yield_function(stress, state) / most, 0.0, atol=1e-14)
    np.testing.assert_allclose(circle.yield_function(stress, state) / most, 0.0, atol=1e-13)


def test_cohesion_means_the_same_tensile_apex_in_every_law():
    c, phi = 4e3, 30.0
    apex = c / np.tan(np.radians(phi))
    strength = {"friction_angle": phi, "cohesion": c}
    laws = [MohrCoulomb(**SOIL, **strength), *(DruckerPrager(**SOIL, **strength, cone=name) for name in cone.CONES)]
    laws.append(
        CohesiveCamClay(
            **SOIL,
            critical_slope=conventions.critical_slope(phi),
            cohesion=conventions.cohesion_ratio(c, phi, 30e3),
            hardening=0.0,  # perfectly plastic, to compare apex with apex
            p0=30e3,
        )
    )
    F = diagonal(*(np.array([0.02]),) * 3)
    for law in laws:
        path = MaterialPoint(law).drive(F)
        np.testing.assert_allclose(path.kirchhoff[0], apex * np.eye(3), rtol=1e-9, atol=1e-9 * apex)


def test_bare_ellipse():
    # q at the top of both ellipses, β = .3: the same M in both differs by 26 %
    beta, bare = A.cohesion, 1.2
    law = changed(A, critical_slope=float(conventions.critical_slope_of_bare_ellipse(bare, beta)))
    top = bare * (1.0 + beta) * law.p0 / 2.0
    state = np.array([law.initial_zeta])
    assert law.yield_of_invariants((1.0 - beta) * law.p0 / 2.0, top, state) == pytest.approx(0.0, abs=1e-6)
    assert np.sqrt(1.0 + 2.0 * beta) == pytest.approx(1.26, abs=0.006)


def test_other_forms_of_the_cone_yield_at_the_same_stress():
    # The other programs' functions, as they print them, are zero where the converted law's is
    rng = np.random.default_rng(7)
    lame, G = 5.8e6, 3.8e6
    stress = rng.normal(size=(50, 3, 3)) * 1e4
    stress += stress.transpose(0, 2, 1) - 6e4 * np.eye(3)
    first = np.trace(stress, axis1=1, axis2=2)
    s = stress - first[:, None, None] / 3.0 * np.eye(3)
    j2 = 0.5 * np.einsum("nij,nij->n", s, s)
    p, q = -first / 3.0, np.sqrt(3.0 * j2)
    alpha, k = conventions.drucker_prager_of_j2(0.2, 3e3)
    np.testing.assert_allclose(q - alpha * p - k, np.sqrt(3.0) * (0.2 * first + np.sqrt(j2) - 3e3), rtol=1e-9)
    alpha, k = conventions.drucker_prager_of_tangent(40.0, 2e3)
    np.testing.assert_allclose(q - alpha * p - k, q - p * np.tan(np.radians(40.0)) - 2e3, rtol=1e-12)
    deviator, volume = s / (2.0 * G), first / (3.0 * lame + 2.0 * G)
    printed = np.linalg.norm(deviator, axis=(1, 2)) + 0.3 * volume * (3.0 * lame + 2.0 * G) / (2.0 * G)
    alpha = conventions.drucker_prager_of_log_strain(0.3)
    np.testing.assert_allclose(q - alpha * p, np.sqrt(6.0) * G * printed, atol=1e-8)
