"""`snowmpm element`: what it leaves, what it says, and bad input."""

import csv
import os

import numpy as np
import pytest

from snowmpm.materials import EXPERIMENTS, measure
from snowmpm.scenes.material_source import load_material

SLAB = ("--material", "slab_release:slab")
MCC = ("-m", "kind=modified_cam_clay")
NUMBERS = {
    "density": 250.0,
    "youngs_modulus": 3e6,
    "poisson_ratio": 0.3,
    "critical_slope": 0.5,
    "hardening": 1.0,
    "p0": 3e3,
}
SETTINGS = tuple(word for key, value in NUMBERS.items() for word in ("--set", f"{key}={value}"))


def read(file):
    """Columns of a table, with their units in the name."""
    with open(file, newline="") as text:
        rows = list(csv.reader(text))
    return {name: np.array([float(x) if x else np.nan for x in column]) for name, *column in zip(*rows, strict=True)}


def test_writes_table_plot_and_material(call, tmp_path):
    result = call("element", "triaxial", *SLAB, "--pressure", "8e3", "--strain", "0.1", "--steps", "40")
    assert (result.code, result.err) == (0, "")
    folder = tmp_path / "runs" / "triaxial_slab"
    assert {path.name for path in folder.glob("[!.]*")} == {"table.csv", "plot.png", "material.toml"}
    for name in ("table.csv", "plot.png", "material.toml"):
        assert f"runs/triaxial_slab/{name}" in result.out.replace(os.sep, "/")
    assert (folder / "plot.png").read_bytes().startswith(b"\x89PNG")
    name, law = load_material("slab_release:slab")
    assert name == "slab"
    found = measure(law, "triaxial", pressure=8e3, strain=0.1, steps=40)
    table = read(folder / "table.csv")
    expected = {f"{column} [{unit}]" if unit else column: values for column, (unit, values) in found.table().items()}
    assert list(table) == list(expected)
    for column, values in expected.items():
        np.testing.assert_array_equal(table[column], values, err_msg=column)  # to the last digit
    for column in ("step", "strain_zz [-]", "stress_xx [Pa]", "p [Pa]", "q [Pa]", "p0 [Pa]", "dissipation [J/m3]"):
        assert column in table
    np.testing.assert_allclose(table["stress_xx [Pa]"], -8e3, rtol=1e-8)


def test_the_material_it_leaves_makes_the_same_test(call, tmp_path):
    options = ("--pressure", "2e3", "--strain", "0.05", "--steps", "20")
    assert call("element", "triaxial", *MCC, *SETTINGS, *options, "-o", "first").code == 0
    assert call("element", "triaxial", "-m", "first/material.toml", *options, "-o", "second").code == 0
    assert (tmp_path / "first/table.csv").read_bytes() == (tmp_path / "second/table.csv").read_bytes()
    # and may be changed again; an earlier test in the folder is replaced
    again = ("-m", "first/material.toml", "--set", "p0=5e3", *options, "-o", "second")
    assert call("element", "triaxial", *again).code == 0
    assert read("second/table.csv")["p0 [Pa]"][0] == pytest.approx(5e3)


def test_says_what_matters(call):
    result = call("element", "triaxial", *MCC, *SETTINGS, "--pressure", "2e3", "--strain", "0.5")
    assert result.code == 0, result.err
    lines = {line.split("  ")[1].strip(): line for line in result.out.splitlines() if line.startswith("  ")}
    assert "p = 2000 Pa, q = 0 Pa" in lines["start"]
    # Overconsolidation ratio 1.5: yields at once, on the wet side, and ends at q = M p, p = 3 σ3 / (3 − M) = 2400 Pa
    assert "step 1: strain_zz = -0.0025" in lines["yield"]
    assert "p = 2400 Pa, q = 1200 Pa, q/p = 0.5" in lines["end"]
    assert "q/p = 0.5" in lines["critical state"]
    elastic = call("element", "oedometer", "-m", "kind=elastic", *SETTINGS[:6], "--strain", "0.01")
    assert "yield           none" in elastic.out and "not reached" in elastic.out


WEAK = ("-m", "pst_2d:weak_layer")


def test_what_a_layer_bore_before_it_collapsed(call):
    """It yields and collapses within a step: what it bore is said, not what is left as its yield."""
    result = call("element", "oedometer", *WEAK, "--strain", "0.02", "--steps", "40")
    assert result.code == 0, result.err
    lines = {line[2:].split("  ")[0].strip(): line for line in result.out.splitlines() if line.startswith("  ")}
    assert "yield" not in lines
    before, after = (float(lines[name].split("p = ")[1].split(" Pa")[0]) for name in ("bears", "yields and drops"))
    assert before > 1000.0 > 20.0 > after
    assert "Cauchy" in lines["p and q"] and "kirchhoff_p" in lines["p and q"]


def test_every_test_has_a_name_and_is_listed(call, monkeypatch):
    listed = call("list").out
    for name, experiment in EXPERIMENTS.items():
        assert name in listed and experiment.summary in listed
    # Dashes are as good as underscores
    result = call("element", "simple-shear-constant-volume", *SLAB, "--strain", "0.1", "--steps", "5", "-o", "shear")
    assert result.code == 0, result.err
    assert read("shear/table.csv")["strain_xz [-]"][-1] == pytest.approx(0.1)


def test_follows_a_path_from_a_file(call, tmp_path):
    (tmp_path / "cycle.csv").write_text("strain_zz,stress_xx,stress_yy\n-0.02,-5e3,-5e3\n-0.01,-5e3,-5e3\n")
    result = call("element", "cycle.csv", *SLAB, "--pressure", "5e3", "--steps", "10")
    assert result.code == 0, result.err
    table = read("runs/cycle_slab/table.csv")
    assert list(table["step"]) == list(range(21))
    assert table["strain_zz [-]"][[10, 20]] == pytest.approx([-0.02, -0.01])
    np.testing.assert_allclose(table["prescribed_stress_xx [Pa]"][1:], -5e3)
    assert np.isnan(table["prescribed_stress_xx [Pa]"][0])


def test_a_card_is_a_material(call):
    result = call("element", "triaxial", "-m", "li_cold_dense", "--pressure", "5e3", "--steps", "20")
    assert result.code == 0, result.err
    assert "triaxial: li_cold_dense (cohesive_cam_clay)" in result.out
    assert read("runs/triaxial_li_cold_dense/table.csv")["p [Pa]"][0] == pytest.approx(5e3)


def test_precision_and_rate_reach_the_law(call):
    for arguments in (("--precision", "f32"), ("--rate", "4")):
        assert call("element", "oedometer", *SLAB, "--steps", "10", *arguments, "-o", arguments[0][2:]).code == 0
    single, slow = read("precision/table.csv"), read("rate/table.csv")
    assert 1e-9 < np.abs(single["p [Pa]"][1:] / slow["p [Pa]"][1:] - 1.0).max() < 1e-4
    assert slow["time [s]"][-1] == pytest.approx(0.1 / 4.0)


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (("brazilian", *SLAB), "no test brazilian: one of isotropic, oedometer, triaxial"),
        (("triaxial", "-m", "slush"), "--material slush: must be a material card, kind=KIND"),
        (("triaxial", "-m", "kind=ice"), '--material kind=ice: must be one of "anticrack_cam_clay"'),
        (("triaxial", "-m", "kind=elastic"), "elastic.density is missing"),
        (("triaxial", "-m", "none.toml"), "none.toml: no such file"),
        (("triaxial", "-m", "empty.toml"), "empty.toml: has no table [material]"),
        (("triaxial", "-m", "slab_release"), "which material? add :NAME, one of slab, weak_layer"),
        (("triaxial", "-m", "slab_release:rock"), 'no material "rock": one of slab, weak_layer'),
        (("triaxial", *SLAB, "--set", "p0=-1"), "slab.p0 = -1: must be >= 0"),
        (("triaxial", *SLAB, "--set", "cohesio=1"), "slab.cohesio = 1: unknown key; did you mean cohesion?"),
        (("triaxial", *SLAB, "--set", "p0"), "must be KEY=VALUE"),
        (("triaxial", *SLAB, "--strain", "0"), "triaxial: strain = 0.0: must be finite and not zero"),
        (("triaxial", *SLAB, "--strain", "nan"), "triaxial: strain = nan"),
        (("triaxial", *SLAB, "--pressure", "-5"), "triaxial: pressure = -5.0: must be >= 0"),
        (("triaxial", *SLAB, "--rate", "0"), "triaxial: rate = 0.0: must be > 0"),
        (
            ("triaxial", "-m", "slab_release_resolved:weak_layer", "--pressure", "1e5"),
            "triaxial: the pressure of 100000 Pa cannot",
        ),
        (("triaxial", *SLAB, "-o", "empty.toml"), "must be a folder"),
        (("none.csv", *SLAB), "none.csv: cannot be read: No such file"),
        (("bad.csv", *SLAB), "bad.csv: line 3, column strain_zz = much: must be a finite number"),
        (("bad.csv", *SLAB, "--strain", "1"), "no --strain, no --rate"),
        (("pull.csv", *SLAB), "cannot be reached; the last before it is xx = "),
    ],
)
def test_bad_input(call, tmp_path, arguments, expected):
    (tmp_path / "empty.toml").write_text("")
    (tmp_path / "bad.csv").write_text("strain_zz\n0.1\nmuch\n")
    (tmp_path / "pull.csv").write_text("stress_xx,stress_yy,stress_zz\n1e5,1e5,1e5\n")
    before = sorted(tmp_path.rglob("*"))
    result = call("element", *arguments)
    assert result.code == 2, result
    assert result.out == ""
    assert expected in result.err
    assert result.err.startswith("error: ") and "Traceback" not in result.err
    assert 1 <= result.err.count("\n") <= 2
    assert sorted(tmp_path.rglob("*")) == before


@pytest.mark.parametrize("arguments", [(), ("triaxial",), ("triaxial", *SLAB, "--steps", "0")])
def test_wrong_usage(call, arguments):
    result = call("element", *arguments)
    assert result.code == 2
    assert result.err
