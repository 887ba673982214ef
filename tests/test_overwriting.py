"""Files of the user: no command replaces one that it reads, or that no earlier command wrote, unless told."""

import os
import time
from pathlib import Path

import pytest

import snowmpm
from snowmpm import overwriting
from snowmpm.draft import draft, write_text
from snowmpm.errors import InputError
from snowmpm.io.archive import write_archive, write_bytes
from snowmpm.io.archive import write_text as write_whole_text
from snowmpm.scenes import load_scene

WRITERS = {"draft": write_text, "archive": write_whole_text,
           "bytes": lambda path, text: write_bytes(path, text.encode()),
           "numbers": lambda path, text: write_archive(path, {"text": text})}


@pytest.fixture(autouse=True)
def another_process(monkeypatch):
    """Forget what this process wrote, as the next command would."""
    forget()
    with overwriting.keeping():
        yield
    forget()


def forget():
    overwriting._written.clear()
    overwriting.forget_inputs()


@pytest.mark.parametrize("write", WRITERS.values(), ids=WRITERS)
def test_own_files_are_replaced_and_others_are_not(tmp_path, write):
    own, foreign = tmp_path / "own.txt", tmp_path / "foreign.txt"
    write(own, "one")
    forget()
    write(own, "two")
    forget()
    foreign.write_text("mine")
    with pytest.raises(InputError, match=r"foreign\.txt: was not written by a command of snowmpm, or was"):
        write(foreign, "one")
    assert foreign.read_text() == "mine"
    own.write_text("edited")
    with pytest.raises(InputError, match=r"own\.txt: was not written .*\n.*--overwrite"):
        write(own, "three")
    with overwriting.keeping(overwrite=True):
        write(own, "three")
        write(foreign, "one")
    assert not [path for path in tmp_path.iterdir() if "unfinished" in path.name or path.suffix == ".part"]


def test_a_function_called_by_name_writes_its_file(tmp_path):
    """Only commands, runs and campaigns keep what is there."""
    (tmp_path / "a.txt").write_text("mine")
    with overwriting.keeping(overwrite=True), overwriting.keeping():
        write_text(tmp_path / "a.txt", "text")
    with overwriting.keeping(overwrite=True), overwriting.keeping(overwrite=False), pytest.raises(InputError):
        (tmp_path / "a.txt").write_text("mine")
        write_text(tmp_path / "a.txt", "more")


def test_a_copied_folder_is_still_known(tmp_path):
    write_text(tmp_path / "one" / "a.txt", "text")
    os.rename(tmp_path / "one", tmp_path / "two")
    os.utime(tmp_path / "two" / "a.txt", (1.0, 1.0))
    forget()
    write_text(tmp_path / "two" / "a.txt", "more")


def test_a_file_edited_by_hand_while_the_program_runs_is_kept(tmp_path):
    path = write_text(tmp_path / "a.txt", "text")
    time.sleep(0.01)
    path.write_text("edited by hand")
    with pytest.raises(InputError, match="changed since"):
        write_text(path, "text")


def test_an_input_is_not_replaced_even_if_it_is_our_own(tmp_path):
    path = write_text(tmp_path / "material.toml", "a = 1")
    forget()
    overwriting.reads(path)
    (tmp_path / "again.toml").hardlink_to(path)
    for name in (path, tmp_path / "x" / ".." / "material.toml", tmp_path / "again.toml"):
        with pytest.raises(InputError, match="is read by this command"):
            write_text(name, "a = 2")


def test_a_link_and_what_it_leads_to_are_kept(tmp_path):
    (tmp_path / "far.txt").write_text("far")
    (tmp_path / "near.txt").symlink_to(tmp_path / "far.txt")
    with pytest.raises(InputError, match="is a link"):
        write_text(tmp_path / "near.txt", "text")
    assert (tmp_path / "near.txt").is_symlink() and (tmp_path / "far.txt").read_text() == "far"
    (tmp_path / overwriting.LIST).unlink(missing_ok=True)
    (tmp_path / overwriting.LIST).symlink_to(tmp_path / "far.txt")
    with pytest.raises(InputError, match="is not a file of snowmpm"):
        write_text(tmp_path / "new.txt", "text")
    assert (tmp_path / "far.txt").read_text() == "far"
    (tmp_path / overwriting.LIST).unlink()
    os.mkfifo(tmp_path / overwriting.LIST)  # nobody writes to it
    with pytest.raises(InputError, match="is not a file of snowmpm"):
        write_text(tmp_path / "new.txt", "text")


def test_an_edit_in_the_middle_of_a_large_file_is_kept(tmp_path):
    """Of the same size, as an editor of rasters leaves it."""
    with draft(tmp_path / "large.tif") as part:
        part.write_bytes(bytes(5_000_000))
    forget()
    with open(tmp_path / "large.tif", "r+b") as file:
        file.seek(2_500_000)
        file.write(b"mine")
    with pytest.raises(InputError, match="changed since"):
        write_text(tmp_path / "large.tif", "text")


def test_files_with_names_of_drafts_are_kept(tmp_path):
    """Of whoever: of the user, or of a program that was killed."""
    (tmp_path / ".page.unfinished.html").write_text("mine")
    write_text(tmp_path / "page.html", "text")
    assert (tmp_path / ".page.unfinished.html").read_text() == "mine" and (tmp_path / "page.html").read_text() == "text"
    assert len(list(tmp_path.iterdir())) == 3
    run = tmp_path / "run"
    for name in ("run.vtkhdf.journal", "checkpoint.npz.part"):
        run.mkdir(exist_ok=True)
        (run / name).write_text("mine")
        with pytest.raises(InputError, match=name):
            snowmpm.run(load_scene(Path(__file__).parent / "resume" / "resumed.toml"), run)
        assert [path.name for path in run.iterdir()] == [name] and (run / name).read_text() == "mine"
        (run / name).unlink()


def test_the_list_stays_short(tmp_path, monkeypatch):
    monkeypatch.setattr(overwriting, "MOST", 2000)
    for i in range(300):
        with draft(tmp_path / "page.html") as part:
            part.write_text(str(i))
    write_text(tmp_path / "other.txt", "text")
    assert (tmp_path / overwriting.LIST).stat().st_size < 2100
    forget()
    write_text(tmp_path / "page.html", "last")


def test_a_run_leaves_the_files_of_its_folder(tmp_path):
    scene = load_scene(Path(__file__).parent / "resume" / "resumed.toml", {"end_time": 0.002, "output.interval": 0.002})
    folder = tmp_path / "run"
    for name in ("scene.toml", "summary.json", "checkpoint.npz", "paraview.vtkhdf", "run.vtkhdf"):
        folder.mkdir(exist_ok=True)
        (folder / name).write_text("mine")
        with pytest.raises(InputError, match=f"{name}: was not written by a command of snowmpm"):
            snowmpm.run(scene, folder)
        assert [path.name for path in folder.iterdir()] == [name] and (folder / name).read_text() == "mine"
        (folder / name).unlink()
    snowmpm.run(scene, folder)
    forget()
    snowmpm.run(scene, folder)
    (folder / "scene.toml").write_text("# mine")
    forget()
    with pytest.raises(InputError, match=r"scene\.toml: was not written"):
        snowmpm.run(scene, folder)
    snowmpm.run(scene, folder, overwrite=True)


def test_a_scene_is_not_replaced_by_its_own_run(tmp_path):
    path = tmp_path / "scene.toml"
    path.write_text("# my comments\n" + (Path(__file__).parent / "resume" / "resumed.toml").read_text())
    with pytest.raises(InputError, match=r"scene\.toml: is read by this command"):
        snowmpm.run(load_scene(path, {"end_time": 0.002}), tmp_path)
    assert path.read_text().startswith("# my comments") and [one.name for one in tmp_path.iterdir()] == ["scene.toml"]


def test_a_list_that_the_disk_takes_half_of_is_as_before(tmp_path, monkeypatch):
    write = overwriting.os.write
    for name in ("a.txt", "b.txt"):
        (tmp_path / name).write_text(name)
    with overwriting.keeping():
        overwriting.note(tmp_path / "a.txt")
        before = (tmp_path / overwriting.LIST).read_bytes()
        monkeypatch.setattr(overwriting.os, "write", lambda file, line: write(file, line[:10]))
        with pytest.raises(OSError, match="No space left"):
            overwriting.note(tmp_path / "b.txt")
        monkeypatch.undo()
        assert (tmp_path / overwriting.LIST).read_bytes() == before
        overwriting.note(tmp_path / "b.txt")
        assert overwriting.is_own(tmp_path / "a.txt") and overwriting.is_own(tmp_path / "b.txt")
