"""The same snow in each format, and what each refuses."""

import re

import numpy as np
import pytest

from snowmpm.errors import InputError
from snowmpm.pit.penetrometer import densities, read_force
from snowmpm.pit.reader import read_profile
from snowmpm.quantities.snow_codes import hardness_code, hardness_index, of_swiss
from tests.support.snow_pits import CSV, LAYERS, PRO, caaml, pnt, write


@pytest.mark.parametrize("name", ["pit.xml", "pit.pro", "pit.csv"])
def test_each_format_holds_the_same_snow(tmp_path, name):
    read = read_profile(write(tmp_path, name))
    assert read.slope_angle == 36.0
    assert [layer.form[:2] for layer in read.layers] == [form[:2] for _, _, form, *_ in LAYERS]
    assert [100 * layer.top for layer in read.layers] == pytest.approx([top for top, *_ in LAYERS])
    assert 100 * read.depth == pytest.approx(90.0)
    assert [layer.size for layer in read.layers] == [size for *_, size, _, _ in LAYERS]
    assert [layer.mean_hardness for layer in read.layers] == [hardness_index(code) for *_, code, _ in LAYERS]
    assert read.layers[1].density == pytest.approx(160.0)


def test_caaml_holds_place_temperatures_and_tests(tmp_path):
    read = read_profile(write(tmp_path))
    assert (read.name, read.elevation, read.aspect, read.place) == ("Made-up slope", 2100.0, "N", (46.8, 9.8))
    assert read.temperatures == ((0.0, -9.0), (0.45, -4.0))
    saw, column = read.tests
    assert (saw.kind, saw.result, saw.cut, saw.column, saw.depth) == ("PST", "End", 0.32, 1.0, 0.45)
    assert str(saw) == "PST 32/100 (End) at 45 cm"
    assert str(column) == "ECTP12 at 45 cm"


@pytest.mark.parametrize("version", ["5.0", "6.0.3", "6.0.6", "7.0"])
def test_caaml_of_any_version(tmp_path, version):
    assert len(read_profile(write(tmp_path, text=caaml(version=version))).layers) == 5


def test_lengths_in_other_units_are_converted(tmp_path):
    layers = [(0.0, 0.5, "RG", 0.4, "1F", None), (0.5, 0.53, "DH", 2.0, "F", None)]
    read = read_profile(write(tmp_path, text=caaml(layers, unit="m", tests=())))
    assert read.depth == pytest.approx(0.53)


def test_a_density_is_of_the_layer_that_holds_half_of_the_sample_or_is_half_sampled():
    from snowmpm.pit.caaml import with_densities
    from snowmpm.pit.profile import Layer

    layers = [Layer(0.0, 1.0), Layer(1.0, 2.0), Layer(2.0, 2.1)]
    samples = [(0.1, 0.2, 100.0), (0.5, 0.8, 140.0), (0.95, 1.3, 200.0), (1.9, 2.08, 300.0)]
    upper, lower, thin = with_densities(layers, samples)
    assert upper.density == pytest.approx((0.1 * 100.0 + 0.3 * 140.0) / 0.4)
    assert lower.density == pytest.approx((0.3 * 200.0 + 0.1 * 300.0) / 0.4)
    assert thin.density == 300.0


def test_a_hardness_that_grows_within_a_layer(tmp_path):
    text = caaml().replace("<hardness uom=''>1F</hardness>",
                           "<hardnessTop uom=''>4F+</hardnessTop><hardnessBottom uom=''>P-</hardnessBottom>")
    assert read_profile(write(tmp_path, text=text)).layers[2].hardness == pytest.approx((2 + 1 / 3, 4 - 1 / 3))


def test_snowpack_takes_snow_alone_and_the_last_step_or_the_one_asked_for(tmp_path):
    path = write(tmp_path, "pit.pro")
    read = read_profile(path)
    assert read.modelled
    assert [layer.density for layer in read.layers] == [80.0, 160.0, 220.0, 210.0, 400.0]
    assert read.layers[-1].form == "MFcr"
    assert read_profile(path, "28.01.2026").time == "28.01.2026 12:00:00"
    with pytest.raises(InputError, match=r"--time 01.10.2025: no profile with snow"):
        read_profile(path, "01.10.2025")


def test_grain_types_with_and_without_one_of_the_surface(tmp_path):
    own = "0513,6,772,550,330,220,110,660"
    for line in (own, "0513,7,0,772,550,330,220,110,660", "0513,5,772,550,330,220,110"):
        read = read_profile(write(tmp_path, "pit.pro", PRO.replace(own, line)))
        assert [layer.form for layer in read.layers] == ["PP", "DF", "RG", "DH", "MFcr"], line
    read = read_profile(write(tmp_path, "pit.pro", PRO.replace("0512,5,1.0,", "0512,5,-999,")))
    assert read.layers[-1].size is None


def test_forces_of_a_hand_are_no_index(tmp_path):
    read = read_profile(write(tmp_path, "pit.pro", PRO.replace("0534,5,4,1,3,2,1", "0534,5,250,20,120,50,20")))
    assert all(layer.hardness is None for layer in read.layers)
    assert "newtons" in read.notes[0]


def test_a_penetrometer_finds_the_surface_and_the_soft_layer(tmp_path):
    path = tmp_path / "one.pnt"
    path.write_bytes(pnt())
    read = read_profile(path)
    assert (read.time, read.format) == ("2026-01-28 12:00:00", "SnowMicroPen")
    assert read.depth == pytest.approx(0.24, abs=0.01)
    lightest = min(read.layers, key=lambda layer: layer.density)
    assert (lightest.top, lightest.bottom) == pytest.approx((0.12, 0.18), abs=0.01)
    assert len(read.layers) <= 8


def test_the_density_of_shot_noise_is_that_of_its_formula():
    """White noise beside its mean: C(1) = 0.5 C(0) where each sample is the mean of two neighbours."""
    noise = np.random.default_rng(2).normal(0.0, 0.05, 200_001)
    for mean in (0.4, 1.0):
        force = mean + 0.5 * (noise[1:] + noise[:-1])
        depth, density = densities(force, 0.01)
        delta = 1.5 * 0.01 / 0.5
        length = (np.pi * 2.5**2 * np.var(force) * delta / (4.0 / 3.0 * mean**2)) ** (1.0 / 3.0)
        log = np.log(mean)
        wanted = 420.47 + 102.47 * log - 121.15 * length * log - 169.96 * length
        assert np.median(density) == pytest.approx(wanted, rel=0.005)
    assert depth[0] == pytest.approx(0.00125)  # middle of the first window of 2.5 mm


def test_force_is_raw_times_factor(tmp_path):
    path = tmp_path / "one.pnt"
    path.write_bytes(pnt(layers=((1.0, 40.0),)))
    force, spacing, _ = read_force(path)
    assert spacing == pytest.approx(0.01)
    assert force[-4000:].mean() == pytest.approx(1.0, rel=0.1)


@pytest.mark.parametrize(("code", "index"), [
    ("F", 1.0), ("4f+", 2 + 1 / 3), ("P-", 4 - 1 / 3), ("F-4F", 1.5), ("I", 6.0), ("2.5", 2.5), ("soft", None)])
def test_hand_hardness(code, index):
    assert hardness_index(code) == (index if index is None else pytest.approx(index))


@pytest.mark.parametrize(("index", "code"), [(1.0, "F"), (2.33, "4F+"), (3.67, "P-"), (5.0, "K")])
def test_hand_hardness_as_code(index, code):
    assert hardness_code(index) == code


def test_codes_of_snowpack():
    assert [of_swiss(code) for code in (110, 330, 772, 770, 990, 0)] == ["PP", "RG", "MFcr", "MF", "FCxr", "PPgp"]


BAD_CAAML = {
    "cut off": (caaml()[:900], r"not valid XML"),
    "no profile": ("<a/>", r"has no <SnowProfileMeasurements>"),
    "entities": (caaml(extra='<!DOCTYPE a [<!ENTITY b "c">]>'), r"has a document type"),
    "file of the system": (caaml(extra='<!DOCTYPE a [<!ENTITY b SYSTEM "file:///etc/passwd">]>'),
                           r"has a document type"),
    "deep": ("<a>" * 200 + "</a>" * 200, r"nested too deeply"),
    "unit of depth": (caaml(unit="ft"), r"layer 1: depthTop: uom = 'ft': must be one of m, cm, mm"),
    "unit of density": (caaml(density_unit="lb/ft3"), r"density 1: uom = 'lb/ft3'"),
    "density in another unit": (caaml([(0, 15, "PP", 1.0, "F", 0.16)]),
                                r"density = 0.16 kg/m3: .* is its unit right\?"),
    "overlap": (caaml([(0, 15, "PP", 1.0, "F", None), (10, 30, "RG", 1.0, "F", None)]),
                r"layers 1 and 2 overlap: 0 to 15 cm and 10 to 30 cm"),
    "upside down": (caaml([(15, 0, "PP", 1.0, "F", None)]), r"thickness = -15 cm: must be above 0"),
    "no layers": (caaml([]), r"has no layers of snow"),
    "word for number": (caaml(angle="steep"), r"slope angle = 'steep': must be a number"),
    "angle": (caaml(angle="95"), r"slope angle = 95 degrees"),
    "nan": (caaml(angle="nan"), r"slope angle = 'nan': must be a number"),
}


@pytest.mark.parametrize("name", BAD_CAAML)
def test_bad_caaml_says_why(tmp_path, name):
    text, message = BAD_CAAML[name]
    with pytest.raises(InputError, match=message) as found:
        read_profile(write(tmp_path, text=text))
    assert str(found.value).startswith(str(tmp_path / "pit.xml"))
    assert "\n" not in str(found.value)


def test_hostile_numbers_are_refused_and_odd_tests_left_out(tmp_path):
    for text, message in (
            (caaml().replace(">-9<", ">-1.7e308<"), "temperature = -1.7e"),
            (caaml().replace(">2100<", ">1e9<"), "elevation"),
            (caaml().replace("<avg>1.0</avg>", "<avg>1e-300</avg>"), "grain size = 1e-300 mm"),
            (PRO.replace("46.8", "nan"), "Latitude = 'nan'"), (PRO.replace("2540", "inf"), "Altitude = 'inf'"),
            (CSV.replace("column [cm] 100", "column [cm] -100"), "column = -1 m"),
            (CSV.replace("cut [cm] 32", "cut 32"), "'cut 32': must be as depth"),
            (CSV.replace(" PP,", " PP\x1b[2J,"), "form = 'PP"),
            (CSV.replace("slope_angle = 36", "slope_angle = 36 deg"), "without a unit, in degrees"),
            ("top; bottom\n0; 20\n", "column top; bottom: must be one of")):
        name = {"<?x": "pit.xml", "[ST": "pit.pro"}.get(text[:3], "pit.csv")
        with pytest.raises(InputError, match=re.escape(message)):
            read_profile(write(tmp_path, name, text))
    read = read_profile(write(tmp_path, "pit.csv", CSV.replace("cut [cm] 32", "cut [cm] 320").replace(
        "# test = ECT, depth [cm] 45", "# test = ECT, depth [cm] 450")))
    assert read.tests == ()
    assert "cut longer than its column: left out" in read.notes[0]
    assert "below the profile: left out" in read.notes[1]


def test_snow_that_is_not_described_is_told(tmp_path):
    read = read_profile(write(tmp_path, text=caaml([(5, 15, "PP", 1.0, "F", None), (20, 30, "RG", 0.4, "1F", None)])))
    assert read.notes[:2] == ("nothing is known from 15 to 20 cm: taken as the layer below it",
                              "nothing is known of the uppermost 5 cm: taken as the layer below it")


def test_a_profile_of_many_layers_and_tests_is_refused_at_once(tmp_path):
    many = caaml([(k, k + 1, "RG", 0.4, "1F", None) for k in range(1001)])
    with pytest.raises(InputError, match="1001 layers"):
        read_profile(write(tmp_path, text=many))
    tests = [("ComprTest", 45, "<testScore>12</testScore>")] * 201
    with pytest.raises(InputError, match="201 tests: at most 1000 and 200"):
        read_profile(write(tmp_path, text=caaml(tests=tests)))


BAD_PRO = {
    "cut off": (PRO.replace("1.0,2.5,0.4,0.75,1.0", "1.0,2.5,0.4"), r"line 20: 3 values, and 5 are announced"),
    "no dates": ("[DATA]\n", r"no profiles"),
    "no snow": (PRO[:PRO.index("0500,28")], r"none of its 1 profiles has snow"),
    "words": (PRO.replace("0503,6,2", "0503,6,warm"), r"line 19: '6,warm.*must be numbers"),
    "downward": (PRO.replace("42,45,60", "45,42,60"), r"heights of elements must grow"),
    "angle": (PRO.replace("SlopeAngle= 36.00", "SlopeAngle= steep"), r"SlopeAngle = 'steep': must be a number"),
}


@pytest.mark.parametrize("name", BAD_PRO)
def test_bad_snowpack_says_why(tmp_path, name):
    text, message = BAD_PRO[name]
    with pytest.raises(InputError, match=message):
        read_profile(write(tmp_path, "pit.pro", text))


BAD_CSV = {
    "column": (CSV.replace("hardness", "hardnes"), r"column hardnes: must be one of .*did you mean hardness\?"),
    "unit": (CSV.replace("[mm]", "[inch]"), r"column size: unit 'inch': must be one of mm, cm, m"),
    "number": (CSV.replace("15, 30, DF", "15, deep, DF"), r"line 7: bottom = 'deep': must be a number"),
    "form": (CSV.replace(" RG,", " XX,"), r"line 8: form = 'XX': must be a code such as"),
    "hardness": (CSV.replace(" 1F,", " hard,"), r"line 8: hardness = 'hard': must be F, 4F"),
    "overlap": (CSV.replace("15, 30", "10, 30"), r"layers 1 and 2 overlap"),
    "key": (CSV.replace("slope_angle", "slope_angel"), r"slope_angel: no key of a profile; did you mean slope_angle\?"),
    "test": (CSV.replace("test = PST", "test = saw"), r"test = 'saw': must begin with one of PST"),
    "test unit": (CSV.replace("cut [cm]", "cut [in]"), r"cut: unit 'in'"),
    "nothing": ("", r"needs a line of column names"),
    "cells": (CSV.replace("48, 90, MFcr, 1.0, P,", "48, 90, MFcr, 1.0, P, , ,"), r"line 10: 8 cells for 6 columns"),
}


@pytest.mark.parametrize("name", BAD_CSV)
def test_bad_table_says_why(tmp_path, name):
    text, message = BAD_CSV[name]
    with pytest.raises(InputError, match=message):
        read_profile(write(tmp_path, "pit.csv", text))


@pytest.mark.parametrize(("change", "message"), [
    (lambda data: data[:300], r"no file of a SnowMicroPen: 300 bytes"),
    (lambda data: data[:5000], r"cut off: \d+ of \d+ samples"),
    (lambda data: bytes(512) + data[512:], r"no file of a SnowMicroPen: firmware 0"),
    (lambda data: data[:358] + b"\x7f\xff\xff\xff" + data[362:], r"2147483647 samples"),
])
def test_bad_penetrometer_says_why(tmp_path, change, message):
    path = tmp_path / "one.pnt"
    path.write_bytes(change(pnt()))
    with pytest.raises(InputError, match=message):
        read_profile(path)


def test_no_file_and_no_format(tmp_path):
    with pytest.raises(InputError, match="no such file"):
        read_profile(tmp_path / "pit.xml")
    with pytest.raises(InputError, match=r"must end in .xml, .caaml, .pro, .pnt, .csv"):
        read_profile(tmp_path / "pit.docx")
