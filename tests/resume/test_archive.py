"""The file of a checkpoint: what is written comes back, and nothing else is taken for it."""

import numpy as np
import pytest

from snowmpm.errors import InputError
from snowmpm.io.archive import read_archive, write_archive
from tests.support.same_runs import assert_same


def test_full_disk_keeps_the_old_checkpoint(tmp_path, monkeypatch):
    path = tmp_path / "c.npz"
    write_archive(path, {"n": 1})

    def full(file, **arrays):
        file.write(b"half")
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(np, "savez", full)
    with pytest.raises(OSError, match=r"No space left on device: .*c\.npz"):
        write_archive(path, {"n": 2}, keep=tmp_path / "c.previous.npz")
    assert read_archive(path) == {"n": 1}
    assert list(tmp_path.iterdir()) == [path]


def test_archive_gives_back_what_it_got(tmp_path):
    tree = {"a": [1, 2.5, None, True, "text"], "b": {"c": np.arange(6, dtype=np.int32).reshape(2, 3)},
            "third": 1.0 / 3.0, "far": float("-inf"), "empty": np.zeros((0, 4), np.float32), "zero-d": np.float64(0.1)}
    write_archive(tmp_path / "a.npz", tree)
    assert_same(read_archive(tmp_path / "a.npz"), {**tree, "zero-d": 0.1})


def test_archive_with_a_part_of_another_is_refused(tmp_path):
    path, other = tmp_path / "a.npz", tmp_path / "b.npz"
    write_archive(path, {"x": np.arange(3.0)})
    with np.load(path) as archive:
        np.savez(other, **{**archive, "x": np.arange(3.0) + 1.0})
    with pytest.raises(InputError, match="checksum"):
        read_archive(other)


class Trap:
    """Makes a file when it is unpickled."""

    def __init__(self, path):
        self.path = path

    def __reduce__(self):
        return open, (str(self.path), "w")


def test_archive_never_unpickles(tmp_path):
    path, sprung = tmp_path / "a.npz", tmp_path / "sprung"
    np.savez(path, record=np.array([Trap(sprung)], dtype=object), digest=np.zeros(32, np.uint8))
    with pytest.raises(InputError, match="damaged"):
        read_archive(path)
    assert not sprung.exists()


def test_a_small_archive_cannot_ask_for_much_memory(tmp_path):
    path = tmp_path / "a.npz"
    np.savez_compressed(path, record=np.zeros(10_000_000, np.uint8), digest=np.zeros(32, np.uint8))
    with pytest.raises(InputError, match="sizes"):
        read_archive(path)
