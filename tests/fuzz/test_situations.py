"""Commands in odd situations: nothing is silent, lost, hanging or ends with a stack trace (`situations.py`)."""

import json
from pathlib import Path

import pytest

import snowmpm
from tests.fuzz import situations


@pytest.fixture(scope="module")
def given(tmp_path_factory):
    """A folder with a finished run of the plain files, and the mass of its snow."""
    folder = tmp_path_factory.mktemp("given")
    situations.TERRAINS["plain"](folder / "dem.asc")
    situations.RELEASES["plain"](folder / "release.geojson")
    (folder / "scene.toml").write_text(situations.SCENE.format(terrain="dem.asc", release="release.geojson"))
    snowmpm.run(snowmpm.load_scene(folder / "scene.toml"), folder / "run")
    return folder / "run", json.loads((folder / "run" / "summary.json").read_text())["last"]["mass"]


def faults(count, seed, given, folder):
    found = [(situations.tried(draw), draw) for draw in situations.draws(count, seed, str(folder), *given)]
    return [(outcome, said[-300:], {key: draw[key] for key in ("terrain", "release", "surroundings", "name", "output",
                                                               "limit", "command")})
            for (outcome, said), draw in found if outcome in situations.FAULTS]


def test_a_few_situations(given, tmp_path):
    assert faults(6, 1, given, tmp_path) == []


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(2, 6))
def test_many_situations(given, tmp_path, seed):
    assert faults(50, seed, given, tmp_path) == []


def test_a_fault_is_seen(given, tmp_path):
    """A changed file, a run without a summary, another mass, a stack trace and a signal count."""
    assert situations.sorted_out((1, "", "Traceback (most recent call last)"), None) == "traceback"
    assert situations.sorted_out((-11, "", ""), None) == "traceback"
    assert situations.sorted_out((None, "", ""), None) == "hang"
    assert situations.sorted_out((0, "", ""), None) == "silent"
    assert situations.sorted_out((2, "", "error: x"), None) == "refused"
    run, mass = given
    assert situations.incomplete(run, {"mass": mass}, "") is None
    assert "mass" in situations.incomplete(run, {"mass": 2.0 * mass}, "")
    assert situations.incomplete(run, {"mass": 2.0 * mass}, "warning: two releases") is None
    assert "no summary" in situations.incomplete(Path(tmp_path), {"mass": mass}, "")
