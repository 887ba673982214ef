"""What the shell offers for names that were begun."""

import os
import subprocess
import sys
from pathlib import Path

import pytest


def offered(line, cwd, shell="bash"):
    """What the program answers to the completion script of a shell for a command line that is being typed."""
    words = line.split(" ")
    environment = {**os.environ, "_SNOWMPM_COMPLETE": f"complete_{shell}", "COMP_WORDS": line,
                   "_TYPER_COMPLETE_ARGS": line, "COMP_CWORD": str(len(words) - 1)}
    command = [sys.executable, "-c", "from snowmpm.cli.app import app; app(prog_name='snowmpm')"]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, cwd=cwd, timeout=60)
    return done.stdout.split("\n")


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ("snowmpm re", "render"),
        ("snowmpm run slab_rel", "slab_release_2d"),
        ("snowmpm run ow", "own.toml"),
        ("snowmpm element triaxial --material li_c", "li_cold_dense"),
        ("snowmpm new x --terrain ", "ground.stl"),
        ("snowmpm info ru", "runs/"),
        ("snowmpm check slab_release_2d --set solver.d", "solver.dx="),
    ],
)
def test_names_are_completed(tmp_path, line, expected):
    for name in ("own.toml", "ground.stl", "runs/one/run.vtkhdf"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).touch()
    assert expected in offered(line, tmp_path)


def test_runs_below_a_folder_of_runs(tmp_path, monkeypatch):
    from snowmpm.cli import completion

    monkeypatch.chdir(tmp_path)
    (tmp_path / "runs" / "one").mkdir(parents=True)
    (tmp_path / "runs" / "two").mkdir()
    (tmp_path / "runs" / "one" / "run.vtkhdf").touch()
    assert [Path(name) for name in completion.runs("ru")] == [Path("runs"), Path("runs/one")]
    assert list(completion.runs("runs/o")) == [str(Path("runs/one"))]


def test_scenes_come_with_what_they_show():
    from snowmpm.cli import completion

    found = dict(completion.library_scenes("slab_release_2"))
    assert found["slab_release_2d"].startswith("A slab avalanche in profile")


class Line:
    """What Typer hands to a completion of a line that names a scene."""

    def __init__(self, scene):
        self.params = {"scene": scene}


@pytest.mark.parametrize(
    ("scene", "begun", "offered", "not_offered"),
    [
        # Set and unset keys of nested tables, of lists of tables, and of a table that is not there
        ("pst_2d", "saw_test.", {"saw_test.slope_angle=", "saw_test.notch=", "saw_test.slab.0.thickness=",
                                 "saw_test.weak_layer.cells=", "saw_test.base.thickness=", "saw_test.width="}, set()),
        ("pst_2d", "saw_test.ends=", {"saw_test.ends=normal", "saw_test.ends=vertical"}, set()),
        ("pst_2d", "saw_test.ends=v", {"saw_test.ends=vertical"}, {"saw_test.ends=normal"}),
        ("pst_2d", "", {"solver.dt=", "end_time="}, {"bodies.0.name=", "domain.min=", "terrain="}),
        ("pst_2d", "initial.", {"initial.stress=", "initial.lateral_pressure="}, set()),
        ("slab_release_2d", "solver.transfer=a", {"solver.transfer=apic", "solver.transfer=aflip"}, set()),
        ("slab_release_2d", "bodies.1.shape.region.", {"bodies.1.shape.region.x="}, set()),
        ("slab_release_2d", "saw_test", set(), {"saw_test.length="}),
    ],
)
def test_keys_of_every_table(scene, begun, offered, not_offered):
    from snowmpm.cli import completion

    found = {one if isinstance(one, str) else one[0] for one in completion.keys(Line(scene), begun)}
    assert offered <= found and not found & not_offered
    assert all(one.startswith(begun) for one in found)


@pytest.mark.parametrize("scene", ["pst", "slab_release_2d"])
def test_every_offered_key_is_one_that_a_scene_may_have(scene):
    """Numbers as they are, given back, are accepted and change nothing."""
    from snowmpm.cli import completion
    from snowmpm.scenes import load_scene
    from snowmpm.scenes.keytree import all_keys
    from snowmpm.scenes.messages import schema_of

    loaded = load_scene(scene)
    keys = list(all_keys(schema_of(type(loaded)), loaded.model_dump(exclude_none=True)))
    offered = [name for name, _ in completion.keys(Line(scene), "")]
    assert len(offered) == len(set(offered)) > 60
    plain = {".".join(map(str, path)): value for path, value, _ in keys if isinstance(value, int | float)}
    again = load_scene(scene, {name: value for name, value in plain.items() if f"{name}=" in offered})
    assert again.solver == loaded.solver and again.saw_test == loaded.saw_test
