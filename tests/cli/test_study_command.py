"""`snowmpm study`, and `snowmpm run --fast` and `--accurate`."""

from snowmpm.scenes import load_scene


def test_an_unknown_study_is_refused_with_those_that_there_are(call):
    done = call("study", "nonsense")
    assert done.code == 2 and "accuracy-speed" in done.err and "scaling" in done.err


def test_an_unknown_problem_is_refused(call):
    done = call("study", "accuracy-speed", "--only", "nonsense")
    assert done.code == 2 and "waves" in done.err


def test_fast_says_what_it_changes_and_the_run_holds_it(call, block, tmp_path):
    fine = {"solver.dx": 0.02}
    done = call("run", block, "-o", tmp_path / "fast", "--set", "solver.dx=0.02", "--fast")
    assert done.code == 0
    assert "--fast: " in done.err and "times faster" in done.err and "times the error" in done.err
    before, after = load_scene(block, fine).solver, load_scene(tmp_path / "fast" / "scene.toml").solver
    assert (after.dx, after.cfl) != (before.dx, before.cfl)


def test_fast_and_accurate_exclude_each_other(call, block):
    done = call("run", block, "--fast", "--accurate")
    assert done.code == 2 and "choose one" in done.err
