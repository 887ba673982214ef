"""Links and other things laid where the program will write: what they lead to stays as it is."""

import os
import shutil
from pathlib import Path

import pytest
from scenes_under_attack import block, written

from snowmpm import draft
from snowmpm.io import archive
from snowmpm.io.journal import PATCH, Journal, open_own
from tests.support.good_run import good_run, journal

pytestmark = pytest.mark.skipif(os.name == "nt", reason="of systems with links")

OURS = b"what belongs to somebody else\n"


@pytest.fixture
def victim(tmp_path):
    (tmp_path / "elsewhere").mkdir()
    return written(tmp_path / "elsewhere" / "victim", OURS)


@pytest.fixture
def run(tmp_path):
    return good_run(tmp_path / "run")


def lay(path, kind, victim):
    """Put a link, or something else that is no file, in a place."""
    path.parent.mkdir(exist_ok=True)
    if path.is_symlink() or path.is_file():
        path.unlink()
    elif path.is_dir():
        shutil.rmtree(path)
    if kind == "link":
        path.symlink_to(victim)
    elif kind == "hard":
        os.link(victim, path)
    elif kind == "dangling":
        path.symlink_to(victim.with_name("made"))
    elif kind == "cycle":
        path.symlink_to(path.name)
    elif kind == "pipe":
        os.mkfifo(path)
    else:
        path.symlink_to("/dev/full")


def untouched(victim):
    assert victim.read_bytes() == OURS
    assert not victim.with_name("made").exists()


KINDS = ["link", "hard", "dangling", "cycle", "pipe"]
OUTPUTS = {
    ".history.unfinished.png": ("plot", "run"), "history.png": ("plot", "run"),
    ".history.unfinished.svg": ("plot", "run", "-o", "run/history.svg"),
    ".picture.unfinished.png": ("render", "run", "--time", "0", "--size", "96x64"),
    "picture.png": ("render", "run", "--time", "0", "--size", "96x64"),
    ".film.unfinished.mp4": ("render", "run", "--size", "96x64"), "film.mp4": ("render", "run", "--size", "96x64"),
    ".film.unfinished.gif": ("render", "run", "--size", "96x64", "-o", "run/film.gif"),
    ".page.unfinished.html": ("render", "run", "-o", "run/page.html"),
    ".report.unfinished.html": ("report", "run", "--still"), "report.html": ("report", "run", "--still"),
    "maps/.peak_depth.unfinished.tif": ("maps", "run"), "maps/peak_depth.tif": ("maps", "run"),
    "maps/.peak_depth.unfinished.png": ("maps", "run", "--files", "pictures"),
    "new/.first.unfinished.toml": ("new", "first", "-o", "run/new"),
    "new/first.toml": ("new", "first", "-o", "run/new", "--overwrite"),
}


@pytest.mark.parametrize("kind", ["link", "dangling"])
@pytest.mark.parametrize("name", OUTPUTS)
def test_outputs(withstood, run, victim, name, kind):
    if name.endswith(".tif"):
        pytest.importorskip("rasterio")
    lay(run / name, kind, victim)
    if ".unfinished" not in name and "--overwrite" not in OUTPUTS[name]:  # a link is somebody's, and is kept
        withstood(*OUTPUTS[name], code=2)
        assert (run / name).is_symlink()
        untouched(victim)
    withstood(*OUTPUTS[name], *(["--overwrite"] if OUTPUTS[name][0] != "new" else []), code=0)
    untouched(victim)
    assert (run / name).is_symlink() == Path(name).name.startswith(".")  # where a draft would go: nobody knows whose


@pytest.mark.parametrize("kind", KINDS)
def test_drafts(tmp_path, victim, kind):
    """Whatever lies where a draft goes stays, where a replacement goes is gone, and what it leads to is as it was."""
    for name in (".table.unfinished.csv", "table.csv"):
        lay(tmp_path / name, kind, victim)
        draft.write_table(tmp_path / "table.csv", ["a"], [[1]])
        assert (tmp_path / "table.csv").read_text() == "a\n1\n" and not (tmp_path / "table.csv").is_symlink()
        untouched(victim)
    for name in ("summary.json.part", "summary.json"):
        lay(tmp_path / name, kind, victim)
        archive.write_text(tmp_path / "summary.json", "{}")
        assert (tmp_path / "summary.json").read_text() == "{}" and not (tmp_path / "summary.json").is_symlink()
        untouched(victim)


FILES = ["run.vtkhdf", "run.vtkhdf.part", "checkpoint.npz", "checkpoint.npz.part", "checkpoint.previous.npz",
         "summary.json", "summary.json.part", "scene.toml", "scene.toml.part"]


@pytest.mark.parametrize("kind", ["link", "dangling"])
def test_a_run_over_links(withstood, tmp_path, victim, kind):
    """A new run puts files of its own in place of all that is linked there."""
    block(tmp_path)
    for name in FILES:
        lay(tmp_path / "out" / name, kind, victim)
    withstood("run", "scene.toml", "-o", "out", "--overwrite", "-q", code=0)
    untouched(victim)
    assert not any(path.is_symlink() for path in (tmp_path / "out").iterdir())


@pytest.mark.parametrize("kind", ["link", "dangling", "cycle", "pipe"])
def test_a_linked_journal_is_refused(tmp_path, victim, kind):
    lay(tmp_path / "run.vtkhdf.journal", kind, victim)
    with pytest.raises(Exception, match=r"is a link|is not a file"):
        Journal(tmp_path / "run.vtkhdf")
    untouched(victim)


def test_a_journal_changes_no_file_behind_a_link(tmp_path, victim):
    """A journal lies beside a link to somebody's file, ready to change it when the run goes on."""
    (tmp_path / "run.vtkhdf").symlink_to(victim)
    (tmp_path / "run.vtkhdf.journal").write_bytes(journal(PATCH.pack(0, 4) + b"evil"))
    with pytest.raises(Exception, match="is a link"):
        Journal(tmp_path / "run.vtkhdf")
    untouched(victim)


def test_what_is_changed_in_place_is_a_file(tmp_path, victim):
    with pytest.raises(Exception, match="is not a file"):
        open_own(tmp_path, os.O_RDONLY)
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(Exception, match="is not a file"):
        open_own(tmp_path / "pipe", os.O_RDWR)


def test_a_scene_is_not_copied_above_its_folder(withstood, tmp_path, victim):
    (tmp_path / "got" / "inner").mkdir(parents=True)
    shutil.copy(victim, tmp_path / "got" / "evil")
    block(tmp_path / "got" / "inner", more='[[obstacles]]\nname = "o"\nshape = { kind = "mesh", file = "../evil" }\n')
    (tmp_path / "mine" / "inner").mkdir(parents=True)
    withstood("new", "copy", "--like", "got/inner/scene.toml", "-o", "mine/inner", code=2)
    assert not (tmp_path / "mine" / "evil").exists()
