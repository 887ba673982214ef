"""Files of a run folder when it is resumed: a backup by links, a copy, one that was edited."""

import os
import shutil
from pathlib import Path

import pytest

import snowmpm
from snowmpm import overwriting
from snowmpm.errors import InputError
from snowmpm.scenes import load_scene


def scene(end_time):
    return load_scene(Path(__file__).with_name("resumed.toml"), {"end_time": end_time, "output.interval": 0.002})


@pytest.fixture(scope="module")
def begun(tmp_path_factory):
    folder = tmp_path_factory.mktemp("begun") / "run"
    snowmpm.run(scene(0.002), folder)
    return folder


@pytest.fixture
def copied(begun, tmp_path):
    """A copy of the run, for a process that did not write it."""
    shutil.copytree(begun, tmp_path / "run")
    overwriting._written.clear()
    return tmp_path / "run"


def resumed(folder):
    return snowmpm.run(scene(0.004), folder, resume=True)


def test_a_backup_by_links_stays_as_it_was(copied, tmp_path):
    backup = tmp_path / "backup"
    shutil.copytree(copied, backup, copy_function=os.link)
    before = {path.name: path.read_bytes() for path in backup.iterdir()}
    assert len(resumed(copied)) == 3
    changed = [name for name, content in before.items() if (backup / name).read_bytes() != content]
    assert changed in ([], [overwriting.LIST])
    assert len(snowmpm.open_run(backup)) == 2


def test_a_copy_without_the_list_is_resumed(copied):
    """As `cp run/* elsewhere` leaves it: hidden files stay behind."""
    (copied / overwriting.LIST).unlink()
    assert len(resumed(copied)) == 3
    overwriting._written.clear()
    snowmpm.run(scene(0.002), copied)


def test_a_summary_that_was_edited_is_kept(copied):
    (copied / "summary.json").write_text("my notes")
    with pytest.raises(InputError, match=r"summary\.json: was not written by a command of snowmpm, or was changed"):
        resumed(copied)
    assert (copied / "summary.json").read_text() == "my notes" and len(snowmpm.open_run(copied)) == 2
