"""A run file read while it is written, and after its writer died: no finished frame lost, no torn one seen."""

import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import h5py
import pytest
from run_states import assert_frame, assert_whole, new_writer, write_frame

from snowmpm.io import Run, RunWriter, journal, transaction

N = 400

# Many small frames as fast as they go: the file is nearly always in the middle of a write.
WRITER = """
import itertools, sys
from run_states import new_writer, write_frame
writer = new_writer(sys.argv[1])
for i in itertools.count():
    write_frame(writer, i, int(sys.argv[2]))
    print(i, flush=True)
"""


def start_writer(folder, n):
    here = str(Path(__file__).parent)
    command = [sys.executable, "-c", WRITER, str(folder), str(n)]
    return subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env={**os.environ, "PYTHONPATH": here})


def wait_for_frames(process, count):
    for _ in range(count):
        process.stdout.readline()


@pytest.mark.parametrize("delay", [0.0, 0.013, 0.029, 0.051])
def test_killed_writer_leaves_every_finished_frame(tmp_path, delay):
    process = start_writer(tmp_path, 5000)
    wait_for_frames(process, 3)
    time.sleep(delay)
    process.send_signal(signal.SIGKILL)
    finished = 3 + len(process.stdout.read().splitlines())
    process.wait()

    run = Run(tmp_path)
    assert len(run) in (finished, finished + 1)  # one more when it died between the commit and the announcement
    assert len(run.history["time"]) == len(run)
    assert not run.complete
    assert_whole(run, 5000)
    with RunWriter.reopen(tmp_path, durable=False) as writer:
        write_frame(writer, len(run), 5000)
    assert len(Run(tmp_path)) == len(run) + 1
    assert_whole(Run(tmp_path), 5000)


def test_reader_follows_a_living_writer(tmp_path):
    process = start_writer(tmp_path, N)
    try:
        wait_for_frames(process, 2)
        counts = []
        while len(set(counts)) < 12:  # states of the file that were seen, however fast the writer is beside the reader
            run = Run(tmp_path)
            counts.append(len(run))
            assert_frame(run, len(run) - 1, N)
    finally:
        process.kill()
        process.wait()
    assert counts == sorted(counts)
    assert_whole(Run(tmp_path), N)


def test_reading_across_a_commit_is_repeated(tmp_path):
    """A reader must not mix two states: what it did while a frame came in is done again."""
    writer, attempts = new_writer(tmp_path), []
    write_frame(writer, 0, N)
    run = Run(tmp_path)

    def action(h5):
        attempts.append(int(h5["VTKHDF/Steps"].attrs["NSteps"]))
        if len(attempts) == 1:
            write_frame(writer, 1, N)
        return attempts[-1]

    assert run._read(action) == 2
    assert attempts == [1, 2]
    writer.close()


def test_a_journal_with_a_damaged_byte_is_not_used(tmp_path):
    """As after a power cut, when the header may reach the disk before what it announces."""
    path = tmp_path / "run.vtkhdf"
    path.write_bytes(bytes(100))
    book = journal.Journal(path, durable=False)
    with open(path, "r+b", buffering=0) as file:
        book.finish = lambda file: None  # dies before it applies them
        book.commit(file, [(10, b"new"), (50, b"bytes")])
    assert journal.read_journal(path) == (1, [(10, b"new"), (50, b"bytes")])
    blob = bytearray(book.path.read_bytes())
    for damaged in (len(blob) - 1, 9):
        torn = blob.copy()
        torn[damaged] ^= 1
        book.path.write_bytes(torn)
        assert journal.read_journal(path)[1] == []
    book.path.write_bytes(blob[:-2])
    assert journal.read_journal(path)[1] == []


def test_the_rest_of_an_unfinished_frame_is_overwritten_not_journaled(tmp_path, monkeypatch):
    with new_writer(tmp_path) as writer:
        write_frame(writer, 0, 20000)
    size = (tmp_path / "run.vtkhdf").stat().st_size
    with open(tmp_path / "run.vtkhdf", "ab") as file:
        file.write(bytes(10**7))
    journaled = []
    commit = journal.Journal.commit

    def measured(self, file, patches):
        journaled.append(sum(len(data) for _, data in patches))
        commit(self, file, patches)

    monkeypatch.setattr(journal.Journal, "commit", measured)
    with RunWriter.reopen(tmp_path, durable=False) as writer:
        write_frame(writer, 1, 20000)
    assert_whole(Run(tmp_path), 20000)
    assert (tmp_path / "run.vtkhdf").stat().st_size == size + 10**7  # the new frame lies in the old tail
    assert max(journaled) < 0.2 * size  # indices, not particles


@pytest.fixture
def moments(tmp_path, monkeypatch):
    """Folders as a kill would leave them: before each single write to the disk, and half-way through it."""
    live, frames = tmp_path / "live", []
    kept = []

    def keep():
        folder = tmp_path / f"moment_{len(kept)}"
        shutil.copytree(live, folder)
        kept.append((folder, len(frames)))

    def recording_write(file, address, data):
        keep()
        if len(data) > 1:
            original(file, address, memoryview(data).cast("B")[: len(data) // 2])
            keep()
        original(file, address, data)

    original = journal.write_all
    writer = new_writer(live)
    for module in (journal, transaction):
        monkeypatch.setattr(module, "write_all", recording_write)
    for i in range(2):  # of the first the tables are new, of the second and all later ones they grow
        write_frame(writer, i, N)
        frames.append(i)
    monkeypatch.undo()
    writer.close()
    return kept


def test_every_moment_of_a_write_leaves_a_whole_file(moments):
    assert len(moments) > 100
    unfinished = 0
    for folder, finished in moments:
        run = Run(folder)
        assert len(run) in (finished, finished + 1)
        assert len(run.history["time"]) == len(run)
        assert_whole(run, N)
        if journal.read_journal(run.path)[1]:
            unfinished += 1
        else:
            with h5py.File(run.path, "r") as h5:  # a program that knows no journal sees the same frames
                assert h5["VTKHDF/Steps"].attrs["NSteps"] == len(run)
    assert unfinished > 5


def test_a_writer_continues_from_any_moment(moments):
    for folder, _ in moments[::7]:
        count = len(Run(folder))
        with RunWriter.reopen(folder, durable=False) as writer:
            write_frame(writer, count, N)
        run = Run(folder)
        assert len(run) == count + 1 and run.complete
        assert_whole(run, N)
        assert {path.name for path in folder.iterdir()} == {"run.vtkhdf", "paraview.vtkhdf"}


@pytest.mark.parametrize("allowed_writes", [0, 5, 20, 40])
def test_full_disk_keeps_the_earlier_frames_and_may_be_continued(tmp_path, monkeypatch, allowed_writes):
    writer = new_writer(tmp_path)
    write_frame(writer, 0, N)
    original, count = journal.write_all, 0

    def failing_write(file, address, data):
        nonlocal count
        count += 1
        if count > allowed_writes:
            raise OSError(28, "No space left on device")
        original(file, address, data)

    for module in (journal, transaction):
        monkeypatch.setattr(module, "write_all", failing_write)
    with pytest.raises(OSError, match="No space left"):
        for i in range(1, 4):
            write_frame(writer, i, N)
    monkeypatch.undo()
    count = len(Run(tmp_path))
    assert_whole(Run(tmp_path), N)
    write_frame(writer, count, N)
    writer.close()
    assert len(Run(tmp_path)) == count + 1
    assert_whole(Run(tmp_path), N)
