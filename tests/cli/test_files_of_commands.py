"""What commands leave of the files that they find."""

import pytest


@pytest.fixture
def run(call, block):
    assert call("run", block, "-o", "run", "--backend", "cpu").code == 0
    return block


def test_a_new_run_names_what_the_old_one_leaves(call, run, tmp_path):
    (tmp_path / "run" / "maps").mkdir()
    (tmp_path / "run" / "film.mp4").write_bytes(b"of the old run")
    again = call("run", run, "-o", "run", "--backend", "cpu", "--overwrite")
    assert again.code == 0 and "film.mp4, maps: of the run that is replaced; make them anew" in again.err
    assert (tmp_path / "run" / "film.mp4").exists()


def test_an_export_leaves_the_files_of_somebody_else(call, run, tmp_path):
    folder = tmp_path / "out"
    folder.mkdir()
    (folder / "mine.ply").write_text("mine")
    refused = call("export", "run", "-o", "out", "--as", "ply")
    assert refused.code == 2 and "mine.ply: was not written by a command of snowmpm" in refused.err
    assert [path.name for path in folder.iterdir()] == ["mine.ply"] and (folder / "mine.ply").read_text() == "mine"
    (folder / "mine.ply").unlink()
    assert call("export", "run", "-o", "out", "--as", "ply").code == 0
    assert call("export", "run", "-o", "out", "--as", "ply").code == 0


def test_a_copy_of_a_scene_that_is_refused_writes_nothing(call, tmp_path):
    refused = call("new", "mine", "--like", "avalanche_depth_averaged", "--set", "solver.dx=-1")
    assert refused.code == 2 and "solver.dx" in refused.err and not list(tmp_path.iterdir())


def test_a_copy_of_a_scene_keeps_a_file_of_that_name(call, tmp_path):
    (tmp_path / "valley.asc").write_text("my valley")
    refused = call("new", "mine", "--like", "avalanche_depth_averaged")
    assert refused.code == 2 and "valley.asc" in refused.err
    assert {path.name: path.read_text() for path in tmp_path.iterdir()} == {"valley.asc": "my valley"}
