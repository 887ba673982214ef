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
