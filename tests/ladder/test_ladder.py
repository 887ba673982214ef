"""The ladder of a scene: its rungs run, its questions are checked, its commands answer."""

import json

import numpy as np
import pytest

from snowmpm.cli.choose import NAMES, place_of, seconds_of, share_of
from snowmpm.cli.run import along_the_front
from snowmpm.errors import InputError
from snowmpm.ladder.answers import FROM_RUN
from snowmpm.ladder.ladder import ladder_of
from snowmpm.ladder.problems import PROBLEMS, Known
from snowmpm.ladder.questions import QUESTIONS, Ask, usual_question
from snowmpm.measured import models
from snowmpm.scenes import load_scene
from snowmpm.scenes.library import library

MOVING = ("block_wall_2d", "boulders_2d", "elastic_beam", "fence_2d", "flexible_wall_2d", "mast")
"""Scenes of the library in which bodies or structures move, or something swings: asked nothing by default."""


@pytest.fixture(scope="module")
def saw():
    scene = load_scene("pst_2d")
    return ladder_of(scene, Ask.of(scene, "critical-length"))


def test_the_command_names_every_question():
    assert set(NAMES) == set(QUESTIONS) and set(FROM_RUN) == set(QUESTIONS) - {"factor-of-safety"}


def test_a_saw_test_has_theories_interfaces_and_resolved_layers(saw):
    kinds = {step.name.partition(",")[0] for step in saw.steps}
    assert kinds == {"energy on a rigid layer", "shear strength", "WEAC", "interface", "resolved"}
    assert saw.own == "resolved, 20 cells"
    assert [step.seconds for step in saw.steps] == sorted(step.seconds for step in saw.steps)


def test_finer_grids_cost_more(saw):
    for kind in ("interface", "resolved"):
        own = [step for step in saw.steps if step.name.startswith(kind)]
        cells = [float(step.name.split()[1]) for step in own]
        assert cells == sorted(cells) and own[-1].seconds > 1.5 * own[0].seconds


def test_what_check_scales_is_near_what_choose_builds():
    from snowmpm.advice.facts import SceneFacts
    from snowmpm.setup.build import build

    scene = load_scene("impact_wall_2d")
    ask, model = Ask.of(scene, "load"), build(scene)
    built, scaled = ladder_of(scene, ask), ladder_of(scene, ask, facts=SceneFacts(scene, model, model.solver()))
    seconds = {step.name: step.seconds for step in built.steps}
    for step in scaled.steps:
        if step.name.startswith("mpm"):
            assert step.seconds == pytest.approx(seconds[step.name], rel=0.35), step.name


def test_a_theory_answers_without_a_run(saw):
    answers = saw.step("WEAC").rung.answers()
    assert answers["critical-length"] == pytest.approx(0.145, abs=0.002)


def test_an_unknown_rung_is_refused_with_those_that_there_are(saw):
    with pytest.raises(InputError, match=r"must be one of .*WEAC"):
        saw.step("nonsense")


@pytest.mark.parametrize(("scene", "name", "message"), [
    ("oedometer", "settlement", "needs gravity"),
    ("pst_2d", "run-out", "a saw test answers critical-length and crack-speed"),
    ("flow_cold_dense", "critical-length", "needs a scene with"),
    ("flow_cold_dense", "affected-area", "three dimensions"),
    ("flow_cold_dense", "load", "needs an obstacle"),
    ("avalanche_depth_averaged", "release", "flows from the start"),
    ("avalanche_depth_averaged", "peak-pressure", "--at X,Y go together"),
    ("avalanche_depth_averaged", "load", "needs an obstacle"),
    ("avalanche_depth_averaged", "nonsense", r"must be one of|expected one of|unknown"),
])
def test_a_question_that_a_scene_cannot_answer_is_refused(scene, name, message):
    with pytest.raises(InputError, match=message):
        Ask.of(load_scene(scene), name)


def test_every_scene_of_the_library_is_asked_something_that_it_answers():
    for name in library():
        scene = load_scene(name)
        if (asked := usual_question(scene)) is not None:
            Ask.of(scene, asked)
        else:
            assert not np.any(scene.gravity_vector) or name in MOVING


@pytest.mark.parametrize(("text", "share"), [("10%", 0.1), ("10 %", 0.1), ("0.05", 0.05), ("150%", 1.5)])
def test_shares(text, share):
    assert share_of(text) == pytest.approx(share)


@pytest.mark.parametrize(("text", "seconds"), [("60", 60.0), ("90s", 90.0), ("5min", 300.0), ("1.5h", 5400.0)])
def test_times(text, seconds):
    assert seconds_of(text) == seconds


@pytest.mark.parametrize("convert", [share_of, seconds_of, place_of])
@pytest.mark.parametrize("text", ["", "x", "-1", "nan", "inf", "0", "1,2,3", "1e999"])
def test_no_shares_times_and_places(convert, text):
    with pytest.raises(InputError):
        convert(text)


def test_choose_prints_the_ladder_and_a_command_that_runs(call):
    code, out, err = call("choose", "pst_2d", "--within", "50%")
    assert code == 0, err
    assert "WEAC" in out and "leaves out" in out
    assert "take: " in out and "next: snowmpm run pst_2d --question critical-length --within 50%" in out


def test_choose_as_json(call):
    code, out, err = call("choose", "pst_2d", "--question", "critical-length", "--within", "50%", "--json")
    assert code == 0, err
    record = json.loads(out)
    assert record["chosen"] in {one["rung"] for one in record["rungs"]} and record["unit"] == "m"


def test_a_rung_runs_and_its_answer_is_written(call, tmp_path):
    code, _, err = call("run", "pst_2d", "--rung", "interface, 2 cells", "-o", "out")
    assert code == 0, err
    record = json.loads((tmp_path / "out" / "answer.json").read_text())
    assert record["question"] == "critical-length" and record["agreed"] is None
    assert record["rungs"][0]["run"] == "interface_2_cells"
    assert (tmp_path / "out" / "interface_2_cells" / "run.vtkhdf").exists()
    known = {row.rung: row for row in models.shipped() if row.problem == "saw test on the flat"
             and row.question == "critical-length"}
    assert record["rungs"][0]["value"] == pytest.approx(known["interface, 2 cells"].value, rel=0.02)


def test_a_rung_runs_on_what_computes_already(monkeypatch, call):
    """Found by a tester: with a GPU, the processor was asked for after it."""
    started = []
    monkeypatch.setattr("snowmpm.cli.run.start_taichi", lambda backend, threads: started.append(backend.value))
    assert call("run", "slope_failure", "--rung", "slices", "--backend", "cuda")[0] == 0 and started == ["cuda"]


def test_a_folder_that_cannot_be_used_is_no_reason_to_climb(call, tmp_path):
    (tmp_path / "out" / "interface_2_cells").mkdir(parents=True)
    (tmp_path / "out" / "interface_2_cells" / "run.vtkhdf").touch()
    code, out, err = call("run", "pst_2d", "--rung", "interface, 2 cells", "-o", "out")
    assert code == 2 and "already holds a run" in err and not out.count("mpm")
    (tmp_path / "file").touch()
    code, _, err = call("run", "pst_2d", "--rung", "WEAC", "-o", "file")
    assert code == 2 and "must be a folder" in err


def test_advice_keeps_what_was_set(call):
    setting = "terrain.friction=0.3"
    code, out, err = call("choose", "avalanche_on_raster", "--question", "run-out", "--within", "50%", "--set", setting)
    assert code == 0 and f"--within 50% --set {setting}" in out, err


def test_a_block_tells_no_pressure_far_beside_its_path(call):
    code, _, err = call("run", "avalanche_on_raster", "--question", "peak-pressure", "--at", "600530,200455",
                        "--rung", "block", "-o", "out")
    assert code == 1 and "gives no answer" in err


def test_the_precision_of_a_scene_stays():
    scene = load_scene("avalanche_on_raster", {"solver.precision": "f64"})
    found = ladder_of(scene, Ask.of(scene, "run-out"))
    assert found.step("depth, 5 m").rung.changes["solver"]["precision"] == "f64"


@pytest.mark.parametrize("words", [
    ["--question", "critical-length"], ["--question", "run-out", "--within", "bogus"], ["--question", "peak-pressure"],
    ["--question", "run-out", "--set", "solver.dx=3"], ["--within", "10%"]])
def test_new_refuses_before_it_copies(call, tmp_path, words):
    assert call("new", "mine", "--like", "avalanche_on_raster", *words, "-o", "out")[0] == 2
    assert not (tmp_path / "out").exists()


def test_snow_too_thin_to_be_resolved_is_not_built():
    """Found by a user's check that took minutes."""
    scene = load_scene("avalanche_depth_averaged", {"bodies.0.shape.top": 0.11})
    found = ladder_of(scene, Ask.of(scene, "run-out"))
    assert "million cells" in found.refused["3-D mpm, 1 cell"] and not any("mpm" in one.name for one in found.steps)


def test_an_answer_is_kept_until_it_may_be_replaced(call, tmp_path):
    def asked(*more):
        return call("run", "pst_2d", "--rung", "shear strength", "-o", "out", *more)

    assert asked()[0] == 0 and asked("--overwrite")[0] == 0
    code, _, err = asked()
    assert code == 2 and "already holds an answer" in err


def test_a_place_beside_the_ground_is_refused(call):
    code, _, err = call("choose", "avalanche_depth_averaged", "--question", "peak-pressure", "--at", "0,0")
    assert code == 2 and "--at 0,0: must lie on the ground" in err


def test_forces_in_profile_are_per_metre_and_water_has_no_measured_errors():
    assert Ask.of(load_scene("impact_wall_2d"), "load").question.unit == "N/m"
    assert Ask.of(load_scene("impact_mast"), "load").question.unit == "N"
    scene = load_scene("slushflow")
    assert all(step.expected is None for step in ladder_of(scene, Ask.of(scene, "run-out")).steps)


def test_an_answer_is_confirmed_by_the_next_rung(call, tmp_path):
    code, _, err = call("run", "slope_failure", "--question", "factor-of-safety", "--budget", "12s", "-o", "out")
    assert code == 0, err
    record = json.loads((tmp_path / "out" / "answer.json").read_text())
    assert 0.6 < record["rungs"][0]["value"] < 1.2 and record["rungs"][0]["expected_error"]["n"] >= 3


def test_new_writes_the_scene_of_the_choice(call, tmp_path):
    code, out, err = call("new", "mine", "--like", "avalanche_on_raster", "--question", "run-out", "--within", "40%")
    assert code == 0, err
    assert "depth, " in out and "error -" in out
    text = (tmp_path / "mine.toml").read_text()
    assert text.startswith("# ") and str(tmp_path) not in text
    scene = load_scene(tmp_path / "mine.toml")
    assert scene.solver.method == "depth" and scene.terrain.file == "valley.asc"
    code, out, err = call("check", "mine.toml")
    assert code == 0 and "asked for run-out: as it is, depth" in out, err


def test_new_keeps_the_comments_where_only_the_grid_changes(call, tmp_path):
    code, _, err = call("new", "mine", "--like", "pst_2d", "--question", "critical-length", "--within", "60%")
    assert code == 0, err
    text = (tmp_path / "mine.toml").read_text()
    assert "# m/s; a hand draws 0.1 m/s" in text
    for words in (["--within", "9%"], ["--question", "run-out", "--like", "pst_2d"]):
        assert call("new", "other", *words)[0] == 2 and not (tmp_path / "other.toml").exists()


@pytest.mark.parametrize("words", [
    ["--obstacle", "wall"], ["--at", "1,2"], ["--within", "20"], ["--rung", "WEAC", "--budget", "9s"],
    ["--question", "critical-length", "--resume"], ["--question", "nonsense"], ["--rung", "nonsense"]])
def test_what_does_not_go_together_is_refused_and_nothing_is_written(call, tmp_path, words):
    code, _, err = call("run", "pst_2d", *words, "-o", "out")
    assert code == 2 and len(err.strip().splitlines()) <= 2
    assert not (tmp_path / "out").exists()


def test_the_shipped_table_has_the_problems_of_the_study():
    shipped = models.shipped()
    assert len({row.problem for row in shipped}) >= 8
    assert set(PROBLEMS) <= {row.problem for row in shipped}
    for row in shipped:
        assert row.question in QUESTIONS and row.seconds > 0.0 and row.forecast > 0.0
        assert row.yes_no == QUESTIONS[row.question].yes_no


def test_known_answers_stand_in_the_table():
    for problem in PROBLEMS.values():
        for name, known in problem.questions.items():
            rows = [row for row in models.shipped() if row.problem == problem.name and row.question == name]
            if isinstance(known, Known):
                assert {row.reference for row in rows} == {known.value}


@pytest.mark.parametrize("name", [
    "pst_2d", *(pytest.param(name, marks=pytest.mark.xfail(strict=True, reason=why)) for name, why in {
        "skier_trigger": "on wider cells it does not release, on a third wider already (docs/models.md)",
        "mast": "its tube is too light for wider cells"}.items())])
def test_fast_does_something_for_every_scene(name):
    assert along_the_front(load_scene(name), fast=True, accurate=False, quiet=True)


def test_fast_says_what_the_next_cheaper_run_would_cost(capsys):
    assert not along_the_front(load_scene("skier_trigger"), fast=True, accurate=False, quiet=False)
    assert "changes nothing: the next cheaper, mpm, 2 x its dx" in (said := capsys.readouterr().err)
    assert "wrong in 62% of cases" in said


def test_a_zone_lies_around_the_obstacle_and_has_its_own_cells():
    wall = {"name": "wall", "contact": "separate", "shape": {
        "kind": "box", "min": [600480.0, 200226.0, 1249.0], "max": [600484.0, 200250.0, 1272.0]}}
    for name in ("avalanche_on_raster", "avalanche_depth_averaged"):
        scene = load_scene(name, {"obstacles": [wall]})
        step = ladder_of(scene, Ask.of(scene, "load"), "zone, 1 cell").step("zone, 1 cell")
        zone = step.rung.changes["zone"]
        assert zone["region"] == {"x": [600440.0, 600524.0], "y": [200186.0, 200290.0]}
        assert 1.5 < zone["solver"]["dx"] < 2.5
        assert ("solver.depth.scheme" in step.rung.changes) == (name == "avalanche_depth_averaged")
