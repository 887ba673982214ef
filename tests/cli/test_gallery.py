"""The gallery: every library scene has a picture on its page, and one command makes both."""

import shutil
import sys
from pathlib import Path

import pytest
from PIL import Image

import snowmpm
from snowmpm.cli.gallery import _in_words
from snowmpm.cli.gallery_page import PAGE, write_page
from snowmpm.render import notes_of
from snowmpm.scenes import library, loader
from snowmpm.scenes.library import FOLDER

GALLERY = FOLDER.with_name("gallery")
BLOCK = Path(__file__).with_name("block.toml")


@pytest.fixture
def small_library(tmp_path, monkeypatch):
    """A library of one scene: the block, two moments of it in the picture and its history below."""
    folder = tmp_path / "library"
    folder.mkdir()
    picture = '[picture]\ntimes = [0.0, 0.02]\ncolor = "density"\nsize = [320, 160]\nplot = "history"\n'
    text = f"# A block falls.\n#\n# Sizes are chosen.\n{BLOCK.read_text()}\n{picture}"
    (folder / "block.toml").write_text(text)
    for module in ("snowmpm.scenes.library", "snowmpm.scenes.loader"):
        monkeypatch.setattr(sys.modules[module], "FOLDER", folder)
    return folder


@pytest.mark.parametrize("name", sorted(library()))
def test_every_library_scene_has_a_picture_on_the_page(name):
    assert (GALLERY / f"{name}.png").is_file(), f"run `snowmpm gallery {name}`"
    page = (GALLERY / PAGE).read_text()
    assert f"({name}.png)" in page
    assert library()[name] in page


def test_one_command_runs_draws_and_writes_the_page(small_library, call, tmp_path):
    done = call("gallery", "-o", tmp_path / "gallery", "--runs", tmp_path / "runs", "--threads", 1)
    assert done.code == 0, done.err
    run = snowmpm.Run(tmp_path / "runs" / "block")
    assert run.complete
    picture = tmp_path / "gallery" / "block.png"
    with Image.open(picture) as drawn:
        assert drawn.width == 320 and drawn.height > 2 * 160 + 100  # two moments and the curves
    assert notes_of(picture)["particles"] == str(run.summary["particles"])
    page = (tmp_path / "gallery" / PAGE).read_text()
    for words in ("## block", "**A block falls.**", "](block.png)", "Sizes are chosen.", run.provenance["device"]):
        assert words in page
    with Image.open(picture) as drawn:
        drawn.convert("RGB").save(picture)  # without its notes, as a program that makes it smaller leaves it
    write_page(picture.parent, _in_words)
    assert (tmp_path / "gallery" / PAGE).read_text() == page


def test_a_finished_run_is_drawn_and_not_run_again(small_library, call, tmp_path):
    arguments = ("gallery", "block", "-o", tmp_path / "gallery", "--runs", tmp_path / "runs", "--threads", 1)
    assert call(*arguments).code == 0
    written = (tmp_path / "runs" / "block" / "run.vtkhdf").stat().st_mtime_ns
    scene = small_library / "block.toml"
    scene.write_text(scene.read_text().replace('plot = "history"\n', ""))  # of the picture: the run stays the same
    assert call(*arguments).code == 0
    assert (tmp_path / "runs" / "block" / "run.vtkhdf").stat().st_mtime_ns == written
    with Image.open(tmp_path / "gallery" / "block.png") as drawn:
        assert drawn.height < 2 * 160 + 20
    scene.write_text(scene.read_text().replace("dx = ", "particles_per_cell = 9\ndx = "))
    refused = call(*arguments)
    assert refused.code == 2 and "particles_per_cell" in refused.err and "--overwrite" in refused.err


def test_a_scene_of_the_users_own_is_no_exhibit(call, tmp_path):
    path = Path(shutil.copy(BLOCK, tmp_path / "mine.toml"))
    refused = call("gallery", path, "-o", tmp_path / "gallery")
    assert refused.code == 2 and "library" in refused.err
    assert loader.load_scene(path).name not in library()
