"""Formulas of the saw test against values worked out apart from them (validation cases S1 to S3)."""

import numpy as np
import pytest

from snowmpm.materials import AnticrackCamClay, Elastic
from snowmpm.materials.anticrack_cam_clay import BAND
from snowmpm.saw_test import theory

SNOW = Elastic(density=250.0, youngs_modulus=3.0e6, poisson_ratio=0.3)
SLAB = theory.Slab.of([(0.5, SNOW)])


def weak_layer(hardening, p0, softening=0.5, **more):
    return AnticrackCamClay(density=100.0, youngs_modulus=0.5e6, poisson_ratio=0.3, critical_slope=1.0, cohesion=0.3,
                            hardening=hardening, p0=p0, softening=softening, **more)


W2, W3 = weak_layer(1.0, 3.0e3), weak_layer(0.5, 1.8e3)


@pytest.mark.parametrize(("law", "load", "shortening"), [(W2, 1471.9, None), (W3, 886.9, 0.02249)])
def test_maxwell_load(law, load, shortening):
    e, P, _, _ = theory.collapse_curve(law)
    found = theory.maxwell_load(e, P)
    assert found[0] == pytest.approx(load, rel=1e-3)
    if shortening:
        assert found[1] == pytest.approx(shortening, rel=2e-3)


def test_no_maxwell_load_without_collapse():
    hardens = np.linspace(0.0, 0.1, 200)
    assert np.isnan(theory.maxwell_load(hardens, 1e5 * hardens)[0])
    assert np.isnan(theory.maxwell_load(hardens, np.exp(-((hardens - 0.03) / 0.01) ** 2))[0])  # never bears it again


def test_maxwell_load_of_a_saw_tooth():
    """P rises to 2 at e = 1, falls to 0 at 2, then rises by 2: sigma e = 2 + (e - 2)^2 with sigma = 2 (e - 2)."""
    e = np.linspace(0.0, 6.0, 6001)
    P = np.interp(e, [0.0, 1.0, 2.0, 6.0], [0.0, 2.0, 0.0, 8.0])
    assert theory.maxwell_load(e, P) == pytest.approx((2.0 * (6.0**0.5 - 2.0), 6.0**0.5), rel=1e-3)


def test_fracture_energy_is_the_work_of_collapse():
    assert theory.fracture_energy(W3, 0.05) == pytest.approx(0.879, rel=2e-3)
    assert theory.fracture_energy(W2, 1.0) == pytest.approx(25.319, rel=2e-3)
    assert np.isnan(theory.fracture_energy(SNOW, 0.05))


def test_speeds_of_the_slab():
    assert SLAB.shear_speed == pytest.approx(67.9366, rel=1e-5)
    assert SLAB.plate_speed == pytest.approx(114.8339, rel=1e-5)
    # 31.6 m/s for h = 1.23 mm with E in place of E' = E / (1 - nu^2)
    assert theory.collapse_speed(SLAB, 1.23e-3) == pytest.approx(31.6 / 0.91**0.25, rel=1e-3)


def test_slab_of_layers():
    two = theory.Slab.of([(0.2, SNOW), (0.3, SNOW)])
    assert two.bending_modulus == pytest.approx(SLAB.bending_modulus, rel=1e-12)
    assert two.shear_modulus == pytest.approx(SLAB.shear_modulus, rel=1e-12)
    soft = SNOW.model_copy(update={"youngs_modulus": 1e6, "density": 100.0})
    hard = SNOW.model_copy(update={"youngs_modulus": 9e6, "density": 300.0})
    sandwich = theory.Slab.of([(0.1, hard), (0.2, soft), (0.1, hard)])
    # B = E_h' (D^3 - d^3) / 12 + E_s' d^3 / 12 about the middle
    stiff = (9e6 * (0.4**3 - 0.2**3) + 1e6 * 0.2**3) / 0.4**3 / 0.91
    assert sandwich.bending_modulus == pytest.approx(stiff, rel=1e-12)
    assert sandwich.density == pytest.approx(200.0)


def test_shear_stiffness_of_layers():
    """One layer however it is divided: 5 G D / 6. Thin stiff faces on a soft core: G_c e^2 / d_c."""
    soft = SNOW.model_copy(update={"youngs_modulus": 1e6})
    faces = SNOW.model_copy(update={"youngs_modulus": 1e9})
    sandwich = theory.Slab.of([(0.01, faces), (0.2, soft), (0.01, faces)])
    assert sandwich.shear_modulus * 0.22 / 1.2 == pytest.approx(soft.shear_modulus * 0.21**2 / 0.2, rel=2e-3)
    assert theory.Slab.of([(0.1, SNOW), (0.25, SNOW), (0.15, SNOW)]).shear_modulus == pytest.approx(SNOW.shear_modulus)
    # Not above the sum of G d, which WEAC takes: the same shear strain in every layer
    graded = [(0.125, SNOW.model_copy(update={"youngs_modulus": modulus * 1e6})) for modulus in (4.0, 3.0, 2.0, 1.0)]
    assert theory.Slab.of(graded).shear_modulus == pytest.approx(2.5e6 / 2.6 / 1.0237, rel=1e-4)


@pytest.mark.parametrize("ends", ["normal", "vertical"])
@pytest.mark.parametrize("slope_angle", [0.0, 35.0, -35.0])
def test_energy_release_rate_is_the_slope_of_the_energy(slope_angle, ends):
    sigma, tau = SLAB.stresses(slope_angle)
    assert sigma == pytest.approx(1226.25 * np.cos(np.radians(slope_angle)))
    assert tau == pytest.approx(1226.25 * np.sin(np.radians(slope_angle)))
    a, d = 0.4, 1e-5
    slope = np.diff([theory.energy_of_cut(SLAB, sigma, tau, a + s * d, ends) for s in (-1, 1)])[0] / (2.0 * d)
    assert theory.energy_release_rate(SLAB, sigma, tau, a, ends) == pytest.approx(slope, rel=1e-7)
    length = theory.critical_length_by_energy(SLAB, sigma, tau, 0.5, ends)
    assert theory.energy_release_rate(SLAB, sigma, tau, length, ends) == pytest.approx(0.5, rel=1e-9)


def test_energy_of_cut_is_the_published_one():
    """As van Herwijnen et al. (2016) write it, of a Poisson ratio of 0, where eta is the same in plane strain."""
    slab = theory.Slab.of([(0.4, SNOW.model_copy(update={"poisson_ratio": 0.0}))])
    for slope_angle in (-40.0, 0.0, 25.0):
        sigma, tau = slab.stresses(slope_angle)
        for r in (0.05, 0.3, 1.2):
            x, eta = r / 0.4, np.sqrt(0.8)
            tau_tau = 1.0 + 9.0 / 4.0 * eta / x + 9.0 / 4.0 * eta**2 / x**2
            sigma_tau = 9.0 / 2.0 * eta + 9.0 / 2.0 * eta**2 / x
            sigma_sigma = 3.0 * eta**2 + 9.0 / 4.0 * eta * x + 9.0 / 5.0 * x**2
            published = np.pi * r**2 / 6.0e6 * (tau**2 + sigma**2) + r**3 / (6.0 * 0.4 * 3.0e6) * (
                tau_tau * tau**2 + sigma_tau * sigma * tau + sigma_sigma * sigma**2)
            assert theory.energy_of_cut(slab, sigma, tau, r) == pytest.approx(published, rel=1e-12)


def test_a_layer_that_is_critical_before_the_cut():
    """Down a slope the energy of a short cut falls at first: the least length counts, and it may be none."""
    sigma, tau = SLAB.stresses(-35.0)
    at_once = theory.energy_release_rate(SLAB, sigma, tau, 0.0)
    assert at_once > 0.0 and theory.critical_length_by_energy(SLAB, sigma, tau, 0.99 * at_once) == 0.0


def test_critical_length_by_strength():
    sigma, _ = SLAB.stresses(0.0)
    reach = np.sqrt(SLAB.stretching_modulus * 0.5 * 0.05 / W3.shear_modulus)
    assert reach == pytest.approx(0.65465, rel=1e-5)
    flat = theory.critical_length_by_strength(SLAB, sigma, 0.0, 1000.0, 0.05, W3.shear_modulus)
    assert flat == pytest.approx(reach * np.sqrt(2.0 * 1000.0 / sigma), rel=1e-12)
    assert np.isnan(theory.critical_length_by_strength(SLAB, sigma, 1000.0, 999.0, 0.05, W3.shear_modulus))


def test_shear_strength_is_on_the_yield_surface():
    strength = theory.shear_strength(W3, 1226.25)
    lateral = W3.lateral_pressure * 1226.25
    stress = -np.diag([lateral, lateral, 1226.25])
    stress[0, 2] = stress[2, 0] = strength
    assert abs(W3.yield_function(stress, np.array(W3.initial_state()))) < 1e-6 * W3.p0**2
    assert theory.shear_strength(W3, 1.0e4) == 0.0  # broken by the load alone


def test_softening_of_a_row_keeps_the_energy_of_the_layer():
    """ξ in proportion to the height of the row: w_f and collapse are those of the reference thickness on any grid."""
    law = weak_layer(0.5, 1.8e3, reference_thickness=0.05)
    for dx in (0.02, 0.0125):
        row = law.on_grid(dx)
        assert theory.fracture_energy(row, BAND * dx) == pytest.approx(theory.fracture_energy(law, 0.05), rel=0.03)
        assert row.p0 == law.p0 and row.youngs_modulus == law.youngs_modulus
        e, P, _, _ = theory.collapse_curve(row, largest=0.6)
        assert theory.maxwell_load(e, P)[0] == pytest.approx(886.9, rel=0.03)
    assert weak_layer(0.5, 1.8e3).on_grid(0.01) == W3
    with pytest.raises(ValueError, match="snaps back"):
        law.on_grid(1.0)


@pytest.mark.parametrize(("dx", "tolerance"), [(0.025, 0.02), (0.0125, 0.03), (0.005, 0.1)])
def test_layer_drawn_two_cells_thick(dx, tolerance):
    """Stiffness, load, collapse and energy per area are those of 50 mm on any grid; where a row of cells is not much
    higher than it collapses, 1.2 mm, its finite strain tells (9 % in the Maxwell load at 5 mm)."""
    row = W3.thickened_to(0.05, 2.0 * dx).on_grid(dx)
    assert row.bulk_modulus / (2.0 * dx) == pytest.approx(W3.bulk_modulus / 0.05, rel=1e-12)
    assert theory.fracture_energy(row, BAND * dx) == pytest.approx(theory.fracture_energy(W3, 0.05), rel=tolerance)
    e, P, _, _ = theory.collapse_curve(row, largest=0.6)
    assert theory.maxwell_load(e, P)[0] == pytest.approx(886.9, rel=tolerance)
