"""One program at a time in a folder, on any system."""

import subprocess
import sys

import pytest

from snowmpm.errors import InputError
from snowmpm.io import FolderLock, locks
from snowmpm.io.journal import Journal

HOLDER = """
import sys
from snowmpm.io import FolderLock, locks
if sys.argv[2] == "without":
    locks.fcntl = None
with FolderLock(sys.argv[1]) as lock:
    lock.make()
    print("held", flush=True)
    sys.stdin.read()
"""


@pytest.fixture(params=["with", "without"])
def system(request, monkeypatch):
    """A system that locks folders, and one, such as Windows, that locks files only."""
    if request.param == "without":
        monkeypatch.setattr(locks, "fcntl", None)
    return request.param


def test_a_second_lock_is_refused(system, tmp_path):
    with FolderLock(tmp_path), pytest.raises(InputError, match="another program is running there"), \
            FolderLock(tmp_path):
        pass
    with FolderLock(tmp_path):
        pass


def test_a_second_writer_is_refused(system, tmp_path):
    first = Journal(tmp_path / "run.vtkhdf")
    with pytest.raises(InputError, match="another program is writing this run"):
        Journal(tmp_path / "run.vtkhdf")
    first.close()
    Journal(tmp_path / "run.vtkhdf").close()


def test_the_lock_of_a_killed_program_is_free(system, tmp_path):
    process = subprocess.Popen([sys.executable, "-c", HOLDER, str(tmp_path), system], stdin=subprocess.PIPE,
                               stdout=subprocess.PIPE, text=True)
    assert process.stdout.readline() == "held\n"
    with pytest.raises(InputError, match="another program"), FolderLock(tmp_path):
        pass
    process.kill()
    process.wait()
    with FolderLock(tmp_path):
        pass
