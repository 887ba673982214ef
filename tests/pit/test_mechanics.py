"""Parametrisations beside the tables of their sources, and the candidates for a weak layer."""

from dataclasses import replace

import numpy as np
import pytest

from snowmpm.pit import mechanics
from snowmpm.pit.profile import Layer, SnowProfile, StabilityTest
from snowmpm.pit.reader import read_profile
from snowmpm.pit.weak_layers import candidates
from tests.support.snow_pits import write

GELDSETZER = {"PP": (81, 117, 153, 189, 225), "PPgp": (120, 157, 194, 231, 268), "DF": (101, 137, 173, 209, 245),
              "RG": (156, 167, 202, 273, 394), "RGxf": (133, 175, 217, 259, 301), "FC": (158, 204, 250, 296, 342),
              "FCxr": (120, 184, 248, 312, 376), "DH": (210, 235, 260, 285, 310)}
"""Geldsetzer & Jamieson (2000): density for fist, four fingers, one finger, pencil, knife."""
MODULI = {"bergfeld": (0.38, 2.26, 8.0, 21.4, 47.7), "scapozza": (0.06, 0.47, 2.1, 6.5, 16.5),
          "gerling": (0.95, 6.1, 23, 64, 149), "van_herwijnen": (0.83, 1.8, 3.7, 7.8, 16)}
"""MPa at 100, 150, 200, 250, 300 kg/m3."""


@pytest.mark.parametrize("form", GELDSETZER)
def test_densities_are_those_of_the_table(form):
    found = [mechanics.density(Layer(0.0, 0.1, form, hardness=(step, step))) for step in (1.0, 2.0, 3.0, 4.0, 5.0)]
    assert [value for value, _ in found] == pytest.approx(GELDSETZER[form], abs=1.0)
    assert {source for _, source in found} == {"hardness"}


@pytest.mark.parametrize(("layer", "density", "source"), [
    (Layer(0, 1, "RGsr", hardness=(3.0, 3.0)), 202.0, "hardness"),
    (Layer(0, 1, "FCso", hardness=(1.0, 1.0)), 158.0, "hardness"),
    (Layer(0, 1, "MFcr", hardness=(4.0, 4.0)), 292.0, "form"),
    (Layer(0, 1, "IFil"), 700.0, "form"),
    (Layer(0, 1, "SHsu", hardness=(1.0, 1.0)), 125.0, "form"),
    (Layer(0, 1, "", "DH", hardness=(1.0, 1.0)), 210.0, "hardness"),
    (Layer(0, 1, "RG", density=311.0, hardness=(3.0, 3.0)), 311.0, "measured")])
def test_where_a_density_is_from(layer, density, source):
    assert mechanics.density(layer) == (pytest.approx(density, abs=1.0), source)


def test_hardness_alone_tells_a_density_and_nothing_tells_none():
    """The mean of the forms, from fist to knife."""
    for step, mean in enumerate(np.mean(list(GELDSETZER.values()), axis=0), 1):
        value, source = mechanics.density(Layer(0.0, 0.1, hardness=(step, step)))
        assert (value, source) == (pytest.approx(mean, rel=0.03), "hardness alone")
    assert mechanics.density(Layer(0.0, 0.1)) is None


@pytest.mark.parametrize(("form", "density"), [
    ("PP", 84.9), ("PPgp", 162.3), ("DF", 136.3), ("RG", 247.4), ("RGxf", 220.6), ("FC", 248.2), ("FCxr", 288.8),
    ("DH", 252.8), ("MFcr", 292.3), ("SH", 125.0)])
def test_densities_of_forms_are_the_means_of_the_paper(form, density):
    assert mechanics.density(Layer(0.0, 0.1, form))[0] == pytest.approx(density, rel=0.004)


def test_strengths_heights_and_limits_are_those_of_their_sources():
    """Written out once more, with other units: kPa, mm, shares of the density of ice."""
    assert mechanics.tensile_strength(250.0) == pytest.approx(1e3 * 240.0 * (250.0 / 917.0) ** 2.44, rel=1e-6)
    assert mechanics.collapse_height(0.02) == pytest.approx(1e-3 * 4.70 * (1.0 - np.exp(-20.0 / 7.78)), rel=1e-6)
    assert mechanics.youngs_modulus(250.0) == pytest.approx(1e6 * 6500.0 * (250.0 / 917.0) ** 4.4, rel=1e-6)
    assert mechanics.youngs_modulus(40.0) == mechanics.youngs_modulus(50.0)
    assert mechanics.youngs_modulus(600.0) == mechanics.youngs_modulus(500.0) > mechanics.youngs_modulus(495.0)
    for form, rho, first, exponent in (("MF", 400.0, 21.0, 1.24), ("SH", 150.0, 18.5, 2.11)):
        wanted = 1e3 * first * (rho / 917.0) ** exponent
        assert mechanics.shear_strength(Layer(0.0, 0.1, form), rho) == pytest.approx(wanted, rel=1e-6)
    scatter = mechanics.STRENGTH_SCATTER, mechanics.COLLAPSE_SCATTER, mechanics.DENSITY_SCATTER["measured"]
    assert scatter == (0.35, 0.9, 0.05)
    assert mechanics.COLLAPSE * np.exp(2.0 * mechanics.COLLAPSE_SCATTER) == pytest.approx(2.7, rel=0.3)  # of the field


@pytest.mark.parametrize("law", MODULI)
def test_moduli_are_those_of_their_sources(law):
    found = [1e-6 * mechanics.youngs_modulus(rho, law) for rho in (100.0, 150.0, 200.0, 250.0, 300.0)]
    assert found == pytest.approx(MODULI[law], rel=0.06)  # the table has two or three digits
    assert mechanics.youngs_modulus(20.0, law) == mechanics.youngs_modulus(mechanics.LIGHT, law)


@pytest.mark.parametrize(("form", "kilopascals"), [
    ("FC", 0.74), ("DH", 0.74), ("RG", 1.19), ("DF", 0.84), ("PP", 0.51)])
def test_shear_strength_at_200(form, kilopascals):
    assert mechanics.shear_strength(Layer(0.0, 0.1, form), 200.0) == pytest.approx(1e3 * kilopascals, rel=0.01)


def test_crusts_and_unknown_forms_have_no_shear_strength():
    assert mechanics.shear_strength(Layer(0.0, 0.1, "MFcr"), 300.0) is None
    assert mechanics.shear_strength(Layer(0.0, 0.1), 300.0) is None


def test_softness_is_the_one_of_the_paper():
    """6.21e-9 (rho s)^-2.11 m/Pa with s in m, as Richter et al. (2019) also write it."""
    for rho, size in ((150.0, 1.0), (250.0, 2.5)):
        assert mechanics.softness(rho, size) == pytest.approx(6.21e-9 * (rho * 1e-3 * size) ** -2.11, rel=0.02)


def test_the_test_names_the_weak_layer(tmp_path):
    read = read_profile(write(tmp_path))
    found = candidates(read)
    assert read.layers[found[0].index].form == "DH"
    assert found[0].points == 6
    assert "PST 32/100 (End) at 45 cm" in found[0].reasons
    assert "depth hoar" in found[0].reasons


def test_without_tests_the_threshold_sum_names_it(tmp_path):
    read = replace(read_profile(write(tmp_path)), tests=())
    first = candidates(read)[0]
    assert (read.layers[first.index].form, first.points) == ("DH", 6)
    assert first.reasons == ("depth hoar", "grains of 2.5 mm", "hardness F",
                             "3.0 hand-hardness steps softer than a neighbour",
                             "grains 2.1 mm larger than a neighbour's", "no deeper than a metre")


def _stack(*layers, **more):
    return SnowProfile("name", "file", "CSV", tuple(layers), **more)


def test_limits_of_observed_and_of_modelled_profiles():
    layers = (Layer(0.0, 0.3, "RG", size=0.6, hardness=(3.0, 3.0)),
              Layer(0.3, 0.4, "FC", size=1.1, hardness=(2.0, 2.0)),
              Layer(0.4, 0.9, "RG", size=0.6, hardness=(3.0, 3.0)))
    assert candidates(_stack(*layers))[0].points == 2
    assert candidates(_stack(*layers, modelled=True))[0].points == 6


def test_a_mark_of_the_observer_counts_more_than_points():
    hoar = Layer(0.3, 0.31, "SH", size=5.0, hardness=(1.0, 1.0))
    marked = Layer(0.6, 0.7, "RG", hardness=(3.0, 3.0), concern=True)
    found = candidates(_stack(Layer(0.0, 0.3, "RG", hardness=(3.0, 3.0)), hoar,
                              Layer(0.31, 0.6, "RG", hardness=(3.0, 3.0)), marked))
    assert [one.index for one in found] == [3, 1]


def test_a_test_on_a_border_belongs_to_the_marked_layer_beside_it():
    hoar = Layer(0.29, 0.30, "SH", concern=True)
    profile = _stack(Layer(0.0, 0.29, "RG"), hoar, Layer(0.30, 0.6, "RG"),
                     tests=(StabilityTest("PST", 0.30, "End", 0.3, 1.0),))
    assert profile.index_at(0.30) == 1
    assert candidates(profile)[0].index == 1


def test_no_layer_at_the_surface_and_no_crust_is_a_candidate():
    assert candidates(_stack(Layer(0.0, 0.04, "SH", size=9.0), Layer(0.04, 0.5, "MFcr", size=3.0))) == []


def test_without_forms_a_light_layer_between_heavy_ones():
    layers = (Layer(0.0, 0.3, density=250.0), Layer(0.3, 0.32, density=150.0), Layer(0.32, 0.9, density=290.0))
    found = candidates(_stack(*layers))
    assert [one.index for one in found] == [1]
    assert found[0].reasons == ("150 kg/m3 between 250 and 290",)
