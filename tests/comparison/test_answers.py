"""What is known of scenes: against tables, closed forms and published benchmarks."""

import numpy as np
import pytest

from snowmpm.comparison import Quantity
from snowmpm.comparison.answers import ANSWERS
from snowmpm.comparison.answers.cantilever import end_deflection
from snowmpm.comparison.answers.column import plane_height, plane_runout, round_height, round_runout
from snowmpm.comparison.answers.oedometer import oedometric_path
from snowmpm.comparison.answers.slope_stability import Slope, plane_strain_strength, upper_surface
from snowmpm.comparison.answers.wall_thrust import largest_friction, wedge_bounds
from snowmpm.scenes.reference import Reference

SNOW = {"kind": "cohesive_cam_clay", "youngs_modulus": 3e6, "poisson_ratio": 0.3, "critical_slope": 1.5,
        "cohesion": 0.3, "hardening": 1.0, "p0": 30e3}
SOFT = {**SNOW, "youngs_modulus": 1e6, "critical_slope": 1.2, "hardening": 0.1, "p0": 20e3}
SAND = {"kind": "hypoplastic", "density": 1850.0, "youngs_modulus": 2.1e7, "poisson_ratio": 0.2, "friction_angle": 29.5,
        "dilation_angle": 1.0}


def test_every_kind_of_the_schema_has_an_answer():
    kinds = {member.model_fields["kind"].annotation.__args__[0] for member in Reference.__origin__.__args__}
    assert kinds == set(ANSWERS)


def test_laws_of_columns():
    """At a = 0.5, 1, 2, 4, 8: the published laws as numbers."""
    assert [1.0 + plane_runout(a) for a in (0.5, 1, 2, 4, 8)] == pytest.approx([1.6, 2.2, 3.4, 5.7876, 8.6], rel=1e-4)
    assert plane_height(1.0) == (1.0, 1.0)
    assert plane_height(4.0) == pytest.approx((1.7411, 1.9152), rel=1e-4)
    assert [1.0 + round_runout(a) for a in (0.5, 1, 4)] == pytest.approx([1.62, 2.24, 4.2])
    assert round_height(0.5) == (0.5, 0.5) and round_height(64.0) == pytest.approx((1.76, 1.76))


def test_a_band_has_no_error_inside():
    assert [Quantity("h", "m", value, 1.0, 2.0).error for value in (0.5, 1.0, 1.7, 3.0)] == [-0.5, 0.0, 0.0, 0.5]


def test_a_beam_swings_about_its_deflection_at_rest():
    """qL^4 / 8 EI, twice of it at the lowest, in the period of the first mode; validation case M11: 0.5355 Hz."""
    law = {"youngs_modulus": 1e6, "poisson_ratio": 0.3, "density": 1000.0}
    rest = 0.1 * 1000.0 * 0.2 / (8.0 * 1e6 / 0.91 * 0.1**3 / 12.0)
    time = np.linspace(0.0, 200.0, 200_001)  # many periods of incommensurable modes
    swing = end_deflection(time, 1.0, 0.1, law, 0.2)
    assert swing.mean() == pytest.approx(rest, rel=2e-3)
    first = time < 1.5
    assert swing[first].max() == pytest.approx(2.0 * rest, rel=0.03)
    assert time[first][swing[first].argmax()] == pytest.approx(0.5 / 0.5355, rel=0.02)


@pytest.mark.parametrize(("material", "strain", "axial", "p", "q"), [
    (SNOW, 0.01, 36841.978, 23175.819, 19949.363), (SNOW, 0.1, 200230.67, 125783.70, 83088.755),
    (SOFT, 0.2, 46017.973, 30007.492, 11503.256)])
def test_path_of_snow(material, strain, axial, p, q):
    """Validation T1.3, integrated elsewhere to 1e-11."""
    found = oedometric_path(material, np.array([0.0, 0.5 * strain, strain]))[-1]
    assert found[0] == pytest.approx(axial, rel=1e-6)
    assert found[1] == pytest.approx((p - q / 3.0) * np.exp(strain), rel=1e-6)


def test_path_of_sand():
    """Axial stress over the pressure at the start, and the ratio to the lateral one, in loading; the stress at which
    unloading has lost 80 %."""
    path = oedometric_path(SAND, np.array([0.0, 0.005, 0.01, 0.02, 0.02 - 0.00202]), 1e4)
    np.testing.assert_allclose(path[1:4, 0] / 1e4, [5.714, 31.83, 1002.0], rtol=1e-3)
    np.testing.assert_allclose(path[1:4, 1] / path[1:4, 0], [0.620, 0.541, 0.514], rtol=2e-3)
    assert path[4, 0] / path[3, 0] == pytest.approx(0.2, abs=2e-3)
    assert path[4, 1] / path[4, 0] == pytest.approx(0.788, abs=2e-3)


def test_elastic_path():
    path = oedometric_path({"kind": "elastic", "youngs_modulus": 1e6, "poisson_ratio": 0.25}, np.array([0.0, 0.1]))
    np.testing.assert_allclose(path[1], np.array([1.2e5, 0.4e5]) * np.exp(0.1))
    with pytest.raises(ValueError, match="no exact path of mu_i"):
        oedometric_path({"kind": "mu_i"}, np.array([0.0, 0.1]))


@pytest.mark.parametrize("degrees", [20.0, 30.0, 40.0])
def test_wedges_of_a_level_fill(degrees):
    """A smooth upright wall, level fill on rough ground: Rankine's 1/2 K gamma H^2, K = tan^2(45 -+ phi/2)."""
    phi, s = np.radians(degrees), np.linspace(0.0, 20.0, 4001)
    bounds = wedge_bounds(s, np.full(len(s), 2.0), 1500.0, (0.0, 10.0), phi, phi, 0.0)
    ranks = [np.tan(np.pi / 4.0 + sign * phi / 2.0) ** 2 for sign in (-1.0, 1.0)]
    np.testing.assert_allclose(bounds, 0.5 * 15000.0 * 4.0 * np.array(ranks), rtol=2e-3)


def test_wedges_of_a_block_on_a_steep_bed():
    """Grains too strong to slip inside lie like a block: W (sin - cos mu) to W (sin + cos mu)."""
    s, angle = np.linspace(0.0, 1.0, 201), np.radians(45.0)
    weight = 1000.0 * 9.81 * 0.2
    low, high = wedge_bounds(s, np.full(len(s), 0.2), 1000.0, 9.81 * np.array([np.sin(angle), np.cos(angle)]),
                             np.radians(80.0), np.arctan(0.5), 0.0)
    assert (low, high) == pytest.approx((weight * np.cos(angle) * 0.5, weight * np.cos(angle) * 1.5), rel=1e-6)


def test_friction_of_a_cone_in_plane_strain():
    """A cone matched to the associated limit state gives its angle back; one without dilation is a little stronger."""
    tan = np.tan(np.radians(35.0))
    alpha = 3.0 * np.sqrt(3.0) * tan / np.sqrt(9.0 + 12.0 * tan**2)
    angle = np.degrees(np.arcsin(3.0 * alpha / (6.0 + alpha)))  # of triaxial compression with this slope
    law = {"kind": "drucker_prager", "friction_angle": angle, "cone": "triaxial_compression", "dilation_angle": 0.0}
    assert np.degrees(largest_friction(law)) == pytest.approx(35.0, abs=1e-6)
    plane = {**law, "friction_angle": 35.0, "cone": "plane_strain"}
    assert 35.0 < np.degrees(largest_friction(plane)) < 38.0


def test_strength_in_plane_strain():
    """The cone of triaxial compression, 30 degrees, without dilation: sin phi = 1.2 / sqrt 3; the apex stays."""
    law = {"kind": "hypoplastic", "friction_angle": 30.0, "cohesion": 1000.0, "dilation_angle": 0.0}
    cohesion, angle, dilation = plane_strain_strength(law)
    assert np.sin(angle) == pytest.approx(1.2 / np.sqrt(3.0))
    assert cohesion / np.tan(angle) == pytest.approx(1000.0 / np.tan(np.radians(30.0)))
    assert dilation == 0.0


ACADS = np.array([[20.0, 20.0], [70.0, 20.0], [70.0, 35.0], [50.0, 35.0], [30.0, 25.0], [20.0, 25.0]])


def test_factor_of_a_benchmark_slope():
    """Simple slope of the ACADS programme (Giam and Donald 1989): c = 3 kPa, phi = 19.6 degrees, 20 kN/m3; 1.00 by the
    referee, 0.99 by Bishop's slices in several programs."""
    x, z = upper_surface(ACADS)
    factor = Slope(x, z, 20.0, 20e3, 3e3, np.tan(np.radians(19.6))).critical().factor
    assert factor == pytest.approx(0.99, abs=0.015)


def test_factor_without_friction():
    """Taylor's chart, phi = 0, steeper than 53 degrees: circles through the toe; 60 degrees: N = gamma H / c = 5.24."""
    rise = 5.0 / np.tan(np.radians(60.0))
    x, z = np.array([0.0, 20.0, 20.0 + rise, 45.0]), np.array([10.0, 10.0, 15.0, 15.0])
    slope = Slope(x, z, 10.0, 18e3, 18e3 * 5.0 / 5.24, 0.0)
    assert slope.critical().factor == pytest.approx(1.0, abs=0.01)


def test_upper_surface_of_a_polygon_either_way_round():
    for points in (ACADS, ACADS[::-1], np.roll(ACADS, 2, axis=0)):
        x, z = upper_surface(points)
        np.testing.assert_allclose(x[[0, -1]], [20.0, 70.0])
        np.testing.assert_allclose(np.interp([25.0, 40.0, 60.0], x, z), [25.0, 30.0, 35.0])
