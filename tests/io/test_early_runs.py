"""Runs of early programs, written by their own code, with what their scenes and groups were: every command opens them.

The files of `test_versions` are of each version of the layout. Within a version scenes, laws and groups went on
changing: these four are of the first day (no obstacles, no run-out), of the first with obstacles and run-out, of the
first saw tests (all of version 1), and of the first columns (version 2).
"""

import gzip
import json
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from snowmpm.cli.app import app
from snowmpm.io import Run

FOLDER = Path(__file__).parent / "early_runs"
NAMES = ("slab_of_first_day", "slab_and_house", "saw_test", "columns")
FLOWS = tuple(name for name in NAMES if name != "saw_test")

SUMMARIES = {
    "slab_of_first_day": {"mass": 14649.294912815094, "momentum_x": 92652.89921927001, "front": 10.523284081618012},
    "slab_and_house": {"mass": 14649.294912815094, "momentum_x": 21770.740989911174, "front": 8.756488565603913},
    "saw_test": {"mass": 120.49999730661511, "max_speed": 0.40112803424945614, "removed_particles": 112.0},
    "columns": {"mass": 23094.011306762695, "momentum_x": 151132.08030895167, "front": 19.551901549100876},
}
"""What the summaries beside these runs said of their last step: text, which no version of the layout touches."""


@pytest.fixture(scope="module")
def early(tmp_path_factory):
    """Folders of the runs, by name."""
    folders = {}
    for name in NAMES:
        folders[name] = tmp_path_factory.mktemp(name)
        (folders[name] / "run.vtkhdf").write_bytes(gzip.decompress((FOLDER / f"{name}.vtkhdf.gz").read_bytes()))
    return folders


def said(*words):
    """What a command prints; it must end well."""
    result = CliRunner().invoke(app, [str(word) for word in words])
    assert result.exit_code == 0, result.output
    return result.output


@pytest.mark.parametrize("name", NAMES)
def test_history_and_frames_are_what_their_program_said(early, name):
    run = Run(early[name])
    assert run.complete
    for quantity, value in SUMMARIES[name].items():
        assert run.history[quantity][-1] == pytest.approx(value, rel=1e-12), quantity
    if name in FLOWS:  # of equal masses; single precision
        velocity = run.frame(len(run) - 1, ["velocity"]).fields["velocity"]
        assert velocity[:, 0].mean() * run.history["mass"][-1] == pytest.approx(run.history["momentum_x"][-1], rel=1e-5)
    points = run.frame(0, []).points
    assert np.isfinite(points).all() and (points[:, 0] > 0.0).all()


@pytest.mark.parametrize("name", NAMES)
def test_info_names_scene_and_frames(early, name):
    known = json.loads(said("info", early[name], "--json"))
    assert known["provenance"]["scene_name"] in said("info", early[name])
    assert known["complete"] is True


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_they_are_plotted_and_drawn(early, name, tmp_path):
    plot, picture, page = (tmp_path / file for file in ("plot.png", "picture.png", "page.html"))
    said("plot", early[name], "-o", plot)
    said("render", early[name], "-o", picture, "--time", "0.1", "--size", "320x180")
    said("render", early[name], "-o", page)
    assert plot.stat().st_size > 10_000 and picture.stat().st_size > 5_000
    assert "viewer" in page.read_text()


@pytest.mark.parametrize("name", NAMES)
def test_they_are_exported(early, name, tmp_path):
    said("export", early[name], "-o", tmp_path, "--as", "ply")
    run = Run(early[name])
    record = json.loads((tmp_path / "sequence.json").read_text())
    assert record["times"] == run.times.tolist()
    head = (tmp_path / record["files"][-1]).read_bytes()[:200].decode("ascii", "ignore")
    count, known = int(head.split("element vertex ")[1].split()[0]), run.n_points(len(run) - 1)
    # A column is a pile of points, more where it is deeper
    assert count > known if name == "columns" else count == known


@pytest.mark.slow
@pytest.mark.parametrize("name", FLOWS)
def test_their_maps_are_drawn(early, name, tmp_path):
    said("maps", early[name], "-o", tmp_path)
    assert (tmp_path / "peak_depth.png").exists() and (tmp_path / "peak_speed.png").exists()


def test_groups_that_came_later_are_read_where_they_are(early):
    first, house, saw, columns = (Run(early[name]) for name in NAMES)
    assert first.obstacles == {} and first.hazard == {} and not first.saw_test
    struck = house.obstacles["house"]
    steps = np.diff(struck.time, prepend=0.0)
    assert len(struck.vertices) == 8 and struck.force[:, 0].max() > 1e4
    np.testing.assert_allclose((struck.force * steps[:, None]).sum(axis=0)[::2], struck.impulse[-1, ::2], rtol=1e-6)
    assert house.hazard["numbers"]["runout"] == pytest.approx(10.978947368421053)
    assert saw.saw_test.values["time"][-1] == pytest.approx(0.2, abs=0.01)
    assert "depth" in columns.field_names and columns.hazard["numbers"]["runout"] > 0.0
