"""The tutorial, followed to the letter: its own slope, and the scene that `snowmpm new` makes of it."""

import re
from pathlib import Path

import numpy as np
import pytest

import snowmpm
from snowmpm.cli.app import app
from snowmpm.scenes import load_scene

TUTORIAL = Path(__file__).parents[1] / "scenes" / "TUTORIAL.md"
MESH = re.compile(r'python -c "\n(.*?)"\n', re.DOTALL)
COMMANDS = re.compile(r"^snowmpm (.*)$", re.MULTILINE)


def command(*words):
    """What a command line ends with."""
    with pytest.raises(SystemExit) as ended:
        app([str(word) for word in words])
    return ended.value.code or 0


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder in which section 4 was followed as far as the scene."""
    folder = tmp_path_factory.mktemp("tutorial")
    section = TUTORIAL.read_text(encoding="utf-8").split("\n## 4.")[1].split("\n## 5.")[0]
    (mesh,), (new, *_) = MESH.findall(section), COMMANDS.findall(section)
    assert new == "new mine --terrain slope.stl"
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        exec(mesh, {})
        assert command(*new.split()) == 0
    return folder


def lost(folder, out, **overrides):
    scene = load_scene(folder / "mine.toml", {key.replace("__", "."): value for key, value in overrides.items()})
    history = snowmpm.run(scene, out).history
    return history["removed_mass"][-1] / history["mass"][0]


def test_the_scene_passes_its_check(folder, monkeypatch):
    monkeypatch.chdir(folder)
    assert command("check", "mine.toml") == 0


def test_the_release_is_in_the_middle_of_the_slope(folder):
    region = load_scene(folder / "mine.toml").bodies[0].shape.region
    assert abs(np.mean(region.y)) < 2.0 and region.x[0] < 10.0


def test_nothing_of_the_avalanche_leaves_the_slope(folder, tmp_path):
    """On a coarse grid, on which the front comes as far as on a fine one: 93 m by a handful of grains (2 m), 67 m
    (1.1 m), of 120 m."""
    assert lost(folder, tmp_path / "run", solver__dx=2.25, end_time=18.0, output__interval=3.0) == 0.0


@pytest.mark.slow
def test_nothing_of_it_leaves_the_slope_as_it_is_written(folder, tmp_path):
    assert lost(folder, tmp_path / "run") < 0.01
