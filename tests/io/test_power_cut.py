"""A power cut at any moment: of what was written since the disk was last waited for, any part may be missing."""

import os
import random
from pathlib import Path

import numpy as np
import pytest
from run_states import assert_whole, new_writer, write_frame

from snowmpm.errors import InputError
from snowmpm.io import Run, RunWriter, journal, transaction
from snowmpm.io.archive import read_archive, write_archive

N = 60
FRAMES = 3


class Disk:
    """Remembers what of some files is on the disk for sure, and which writes are on their way."""

    def __init__(self, paths):
        self._paths = {os.stat(path).st_ino: path for path in paths}
        self._certain = {path: path.read_bytes() for path in paths}
        self._late = {path: [] for path in paths}

    def write(self, file, address, data):
        path = self._paths[os.fstat(file.fileno()).st_ino]
        self._late[path].append((address, bytes(memoryview(data).cast("B"))))

    def sync(self, descriptor):
        path = self._paths.get(os.fstat(descriptor).st_ino)
        if path is not None:
            self._certain[path], self._late[path] = path.read_bytes(), []

    def after_a_power_cut(self, dice):
        """Content by path: of each late write all, none or a part has arrived, in any order."""
        left = {}
        for path, content in self._certain.items():
            content = bytearray(content)
            for address, data in self._late[path]:
                arrived = data[: dice.choice([0, len(data), dice.randint(0, len(data))])]
                if arrived:
                    content.extend(bytes(max(0, address - len(content))))
                    content[address : address + len(arrived)] = arrived
            left[path] = bytes(content)
        return left


@pytest.fixture
def outages(tmp_path, monkeypatch):
    """[(content of the files by name, frames that were finished)] of a durable writer."""
    writer = new_writer(tmp_path / "live", durable=True)
    disk = Disk([tmp_path / "live" / name for name in ("run.vtkhdf", "run.vtkhdf.journal")])
    dice, kept, finished = random.Random(7), [], []

    def recording_write(file, address, data):
        disk.write(file, address, data)
        kept.append((disk.after_a_power_cut(dice), len(finished)))
        original(file, address, data)

    original = journal.write_all
    for module in (journal, transaction):
        monkeypatch.setattr(module, "write_all", recording_write)
    monkeypatch.setattr(os, "fsync", disk.sync)
    for i in range(FRAMES):
        write_frame(writer, i, N)
        finished.append(i)
        kept.append((disk.after_a_power_cut(dice), len(finished)))
    monkeypatch.undo()
    writer.close()
    return kept


def test_run_file(outages, tmp_path):
    dice = random.Random(8)
    assert len(outages) > 60
    for number, (files, finished) in enumerate(dice.sample(outages, 40)):
        folder = tmp_path / str(number)
        folder.mkdir()
        for path, content in files.items():
            (folder / path.name).write_bytes(content)
        run = Run(folder)
        assert len(run) in (finished, finished + 1)
        assert_whole(run, N)
        if number % 6 == 0:
            with RunWriter.reopen(folder, durable=False) as writer:
                write_frame(writer, len(run), N)
            assert_whole(Run(folder), N)


def test_the_test_would_notice(outages, tmp_path):
    """Without the journal some of those files are torn."""
    for number, (files, finished) in enumerate(random.Random(9).sample(outages, 40)):
        path = tmp_path / f"{number}.vtkhdf"
        path.write_bytes(next(content for file, content in files.items() if file.suffix == ".vtkhdf"))
        try:
            run = Run(path)
            assert len(run) in (finished, finished + 1)
            assert_whole(run, N)
        except (InputError, AssertionError):
            return
    pytest.fail("no file was torn")


@pytest.mark.parametrize("lost", ["nothing", "renaming", "both renamings"])
def test_checkpoint(tmp_path, monkeypatch, lost):
    """A file has its content before it gets its name; of the two renamings the second may be missing, or both."""
    path, keep = tmp_path / "checkpoint.npz", tmp_path / "checkpoint.previous.npz"
    synced, replace, names = {}, os.replace, []
    write_archive(path, {"n": 1, "x": np.arange(100.0)}, keep=keep)

    def recording_sync(descriptor):
        name = os.readlink(f"/proc/self/fd/{descriptor}")
        if not os.path.isdir(name):
            synced[name] = Path(name).read_bytes()

    def power_cut(source, target):
        names.append((Path(source).name, Path(target).name))
        if Path(source).suffix == ".part":
            assert synced[str(source)] == Path(source).read_bytes()
        if len(names) <= {"nothing": 2, "renaming": 1, "both renamings": 0}[lost]:
            replace(source, target)

    monkeypatch.setattr(os, "fsync", recording_sync)
    monkeypatch.setattr(os, "replace", power_cut)
    write_archive(path, {"n": 2, "x": np.arange(100.0)}, keep=keep)
    monkeypatch.undo()
    assert names == [("checkpoint.npz", "checkpoint.previous.npz"), ("checkpoint.npz.part", "checkpoint.npz")]
    whole = path if path.exists() else keep
    assert read_archive(whole)["n"] == (2 if lost == "nothing" else 1)
