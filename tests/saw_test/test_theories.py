"""Measured numbers beside theories: what is set beside what, the word where they lie far apart, tables and figures."""

import json

import numpy as np
import pytest
from typer.testing import CliRunner

import snowmpm
from snowmpm.cli.app import app
from snowmpm.io.saw_theories import APART, compared
from snowmpm.io.saw_words import set_up
from snowmpm.render.saw_test_plot import saw_test_figure

ABOUT = {"slope_angle": 0.0, "saw_speed": 2.0, "saw_start": 0.02, "saw_length": 1.0, "notch": 0.0,
         "normal_stress": 1226.25, "shear_stress": 0.0}
FOUND = {"critical_length": 0.2, "crack_speed": 44.0, "fracture_energy": 0.85,
         "theory": {"critical_length_energy": 0.52, "critical_length_strength": 0.35, "collapse_wave_speed": 31.6,
                    "fracture_energy": 0.88}}


def test_a_factor_of_two_point_six_gets_a_word():
    pairs = {one.theory.predicted: one for one in compared(FOUND, 0.0)}
    assert set(pairs) == {"critical_length_energy", "critical_length_strength", "collapse_wave_speed",
                          "fracture_energy"}
    apart = [one for one in pairs.values() if one.remark]
    assert [one.theory.predicted for one in apart] == ["critical_length_energy"]
    assert "critical length: a factor of 2.6 below energy, rigid weak layer (Heierli 2008)" in apart[0].remark
    assert "Likely reason: it takes the weak layer for rigid" in apart[0].remark


@pytest.mark.parametrize("factor", [0.9 / APART, 1.1 / APART, 0.9 * APART, 1.1 * APART])
@pytest.mark.parametrize("name", ["critical_length_energy", "critical_length_strength", "critical_length_weac"])
def test_word_from_a_factor_of_two_on_both_sides(name, factor):
    one = next(one for one in compared({"critical_length": 0.2 * factor}, 0.0, {name: 0.2}))
    assert one.ratio == pytest.approx(factor)
    assert (one.remark is None) == (1.0 / APART < factor < APART)
    assert one.remark is None or ("below" if factor < 1.0 else "above") in one.remark


def test_a_flat_theory_says_nothing_of_a_slope():
    assert "collapse_wave_speed" not in {one.theory.predicted for one in compared(FOUND, 30.0)}
    assert compared({}, 0.0) == [] and compared({"critical_length": None, "theory": FOUND["theory"]}, 0.0) == []


def test_set_up_names_the_saw_and_what_a_notch_is():
    words = set_up(ABOUT)
    assert words["saw"] == "takes the weak layer away at 2 m/s, on the flat, from x = 0 m to 1 m, beginning at 0.02 s"
    assert words["notch"].startswith("none") and "notch included" in words["critical length"]
    assert "part of the critical length" in set_up({**ABOUT, "notch": 0.3})["notch"]
    assert "down a slope of 35°" in set_up({**ABOUT, "slope_angle": -35.0})["saw"]


@pytest.mark.parametrize(("slope_angle", "expected"), [(0.0, 0.298), (35.0, 0.232), (-35.0, 0.427)])
def test_critical_length_by_weac(slope_angle, expected):
    """The numbers that `tests/verification/test_anticrack.py` finds by interpolation."""
    pytest.importorskip("weac", reason="WEAC is in the dev extra")
    from snowmpm.saw_test.prediction import column_of
    from snowmpm.saw_test.theory import fracture_energy
    from snowmpm.saw_test.weac import critical_length

    scene = snowmpm.load_scene("pst_2d", {
        "materials.weak_layer": {"card": "gaume_weak_layer"}, "materials.weak_layer.critical_slope": 1.8,
        "saw_test.length": 4.0, "saw_test.slope_angle": slope_angle, "saw_test.ends": "normal"})
    _, law, thickness = column_of(scene)
    assert critical_length(scene, fracture_energy(law, thickness)) == pytest.approx(expected, abs=0.003)
    assert critical_length(scene, 1e9) is None


SHORT = {"solver.dx": 0.05, "saw_test.length": 2.0, "saw_test.saw_speed": 4.0, "saw_test.saw_start": 0.005,
         "saw_test.saw_length": 0.6, "end_time": 0.12, "initial.stress": "geostatic", "output.interval": 0.02}


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """Two short saw tests, one of them on a slope."""
    folder = tmp_path_factory.mktemp("compared")
    return [snowmpm.run(snowmpm.load_scene("pst_2d", {**SHORT, "saw_test.slope_angle": angle}), folder / name)
            for name, angle in (("flat", 0.0), ("steep", 40.0))]


def text_of(figure):
    return "\n".join(" ".join(text.get_text() for text in axes.texts) + axes.get_title(loc="left")
                     for axes in figure.axes).replace("\n   ", " ")


def test_figure_holds_the_theories_and_how_it_was_made(runs):
    figure = saw_test_figure(runs[0], theories={"critical_length_weac": 0.25})
    said = text_of(figure)
    for words in ("critical length, and theories of it", "energy, rigid weak layer (Heierli 2008)",
                  "shear strength (Gaume 2017)", "energy, elastic weak layer (WEAC)", "Maxwell's load: 685 Pa",
                  "at 4 m/s", "notch: none"):
        assert words in said
    lengths = next(axes for axes in figure.axes if "theories of it" in axes.get_title(loc="left"))
    assert any(bar.get_width() == pytest.approx(0.25) for bar in lengths.patches)


def test_an_unfinished_run_says_nothing_of_a_critical_length(runs):
    """Its numbers are worked out when it ends: that no crack ran is not known before."""
    class Unfinished:
        name, saw_test, summary, path = runs[0].name, runs[0].saw_test, {}, runs[0].path
        complete = False

    figure = saw_test_figure(Unfinished)
    said = text_of(figure)
    assert "no crack ran" not in said and "known when the run has ended" in said
    # Theories that need no end of the run are there, and the title says what it is
    assert "energy, rigid weak layer (Heierli 2008)" in said and "Maxwell's load: 685 Pa" in said
    assert figure.get_suptitle().startswith("UNFINISHED, up to 0.12 s")


def test_no_panel_of_a_saw_test_is_one_of_zeros(runs):
    """A column that is cut has no front and no run-out; nothing is said to be missing that the saw took."""
    from snowmpm.io.remarks import remarks
    from snowmpm.render.history_plot import history_figure

    for run in runs:
        assert not {"front", "front_distance"} & set(run.history)
        assert "front" not in [axes.get_title(loc="left") for axes in history_figure(run).axes]
        assert run.history["taken_mass"][-1] == run.history["removed_mass"][-1] > 0.01 * run.history["mass"][0]
        assert not [line for line in remarks(run) if "mass" in line]


def test_energies_that_are_drawn_add_up(runs):
    """What left with the snow that the saw took among them."""
    from snowmpm.render.history_plot import history_figure

    axes = next(one for one in history_figure(runs[1]).axes if one.get_title(loc="left") == "energy")
    drawn = {line.get_label(): line.get_ydata() for line in axes.get_lines()}
    lost = drawn.pop("potential, lost")
    assert abs(drawn["left with snow"][-1]) > 0.1 * abs(lost[-1])
    left_open = sum(drawn.values()) - lost
    np.testing.assert_allclose(left_open, left_open[0], atol=1e-6 * abs(lost).max())


def test_compare_sets_saw_tests_side_by_side(runs, tmp_path):
    folders = [str(run.path.parent) for run in runs]
    done = CliRunner().invoke(app, ["compare", *folders, "-o", str(tmp_path / "both.png")])
    assert done.exit_code == 0, done.output
    assert (tmp_path / "both.png").stat().st_size > 50_000
    found = [json.loads((run.path.parent / "summary.json").read_text())["saw_test"] for run in runs]
    rows = {line[:45].strip(): line[45:].split() for line in done.output.splitlines()}
    length = next(line for line in done.output.splitlines() if line.startswith("critical length [m]"))
    for one in found:
        assert f"{one['critical_length']:.4g}" in length
    for words in ("slope [degrees]", "saw speed [m/s]", "notch [m]", "crack speed [m/s]", "collapse height [m]",
                  "plastic work [J/m]", "largest kinetic energy [J/m]", "Maxwell's load", "Heierli", "Gaume",
                  "Likely reason"):
        assert any(words in name for name in [*rows, done.output])
    assert "front of" not in done.output and "profile" not in done.output


def test_compare_of_a_saw_test_and_another_run(runs, tmp_path):
    """Falls back to what they share."""
    block = snowmpm.run(snowmpm.load_scene("column_collapse_2d", {"end_time": 0.02, "solver.dx": 0.02,
                                                                  "output.interval": 0.01}), tmp_path / "block")
    done = CliRunner().invoke(app, ["compare", str(runs[0].path.parent), str(block.path.parent), "-o",
                                    str(tmp_path / "both.png")])
    assert done.exit_code == 0, done.output
    assert (tmp_path / "both.png").exists()


def test_plot_gives_the_reason(runs):
    done = CliRunner().invoke(app, ["plot", str(runs[0].path.parent)])
    assert done.exit_code == 0 and "Likely reason" in done.output
    assert np.isfinite(runs[0].saw_test.about["saw_length"])
