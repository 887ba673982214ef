"""Run files of every version that there has been are read; of a later one they are refused, with both numbers."""

import shutil
from pathlib import Path

import h5py
import numpy as np
import pytest

from snowmpm.errors import InputError
from snowmpm.io import Run, RunWriter, layout

FROZEN = sorted(Path(__file__).parent.glob("run_version_*.vtkhdf"))
"""Three frames of five particles in each version, as the program of its time wrote them."""


def test_there_is_one_of_each_version():
    assert [path.stem for path in FROZEN] == [f"run_version_{n + 1}" for n in range(layout.FORMAT_VERSION)]


@pytest.mark.parametrize("path", FROZEN, ids=lambda path: path.stem)
def test_a_frozen_file_is_read(path):
    run = Run(path)
    assert run.complete and run.dimension == 3 and run.times.tolist() == [0.0, 0.1, 0.2]
    assert run.origin.tolist() == [100.0, 200.0, 300.0]
    for i in range(3):
        frame = run.frame(i)
        points = np.arange(15.0, dtype=np.float32).reshape(5, 3) + np.float32(i)
        assert np.array_equal(frame.points, points)
        assert np.array_equal(frame.fields["velocity"], 2 * points)
        assert np.array_equal(frame.fields["material"], np.arange(5) % 2)
    assert run.units["velocity"] == "m/s" and run.units["mass"] == "kg"
    assert run.history["mass"].tolist() == [1.0, 2.0, 3.0]
    assert run.provenance == {"seed": 1} and run.hazard == {"numbers": {"runout": 12.0}}
    assert run.terrain.facets.tolist() == [[0, 1, 2]]
    wall = run.obstacles["wall"]
    assert wall.time.tolist() == [0.1, 0.2] and wall.translation[2].tolist() == [0.2, 0.0, 0.0]
    assert run.maps["peak_depth"].values.tolist() == [[0.0, 1.0], [2.0, 3.0]]


@pytest.mark.parametrize("path", FROZEN, ids=lambda path: path.stem)
def test_a_frozen_file_is_continued_as_it_is(path, tmp_path):
    """Frames that are added lie where those before lie, in the form of the file's own version."""
    path = Path(shutil.copy(path, tmp_path / "run.vtkhdf"))
    points = np.arange(15.0, dtype=np.float32).reshape(5, 3) + np.float32(3)
    fields = {"velocity": 2 * points, "material": np.arange(5, dtype=np.int32) % 2}
    with h5py.File(path) as h5:
        before = h5["VTKHDF/Points"][:5]
    with RunWriter.reopen(path, until=0.1, durable=False) as writer:
        writer.frame(0.3, points, fields)
    run = Run(path)
    assert run.times.tolist() == [0.0, 0.1, 0.3] and np.array_equal(run.frame(2).points, points)
    with h5py.File(path) as h5:
        added, start = h5["VTKHDF/Points"], int(h5["VTKHDF/Steps/PointOffsets"][2])
        assert added.dtype == before.dtype and np.array_equal(added[start : start + 5], before + 3)


@pytest.mark.parametrize("attribute, value, message", [
    ("format_version", layout.FORMAT_VERSION + 1, r"format version \d+; this program reads up to \d+"),
    ("format", "another", "not a run file of this program"),
])
def test_what_is_not_known_is_refused(tmp_path, attribute, value, message):
    path = Path(shutil.copy(FROZEN[-1], tmp_path / "run.vtkhdf"))
    with h5py.File(path, "r+") as h5:
        h5.attrs[attribute] = value
    with pytest.raises(InputError, match=message):
        Run(path)


def linked(h5, folder):
    h5["history/stolen"] = h5py.ExternalLink(str(folder / "other.h5"), "/secret")


def soft(h5, folder):
    h5["history/stolen"] = h5py.SoftLink("/VTKHDF")


def external(h5, folder):
    h5["history"].create_dataset("stolen", (4,), "u1", external=[(str(folder / "secret"), 0, 4)])


def virtual(h5, folder):
    source = h5py.VirtualLayout((4,), "u1")
    source[:] = h5py.VirtualSource(str(folder / "other.h5"), "secret", shape=(4,))
    h5["history"].create_virtual_dataset("stolen", source)


def enormous(h5, folder):
    h5["history"].create_dataset("stolen", (1 << 45,), "f8", chunks=(1 << 16,), compression="gzip")


def enormous_by_two_names(h5, folder):
    """One of which is read by frames."""
    enormous(h5, folder)
    h5["surroundings/terrain/stolen"] = h5["history/stolen"]


def enormous_frames(h5, folder):
    h5["VTKHDF/Points"].resize(1 << 40, axis=0)
    h5["VTKHDF/NumberOfPoints"][-1] = 1 << 40


@pytest.mark.parametrize("trick", [linked, soft, external, virtual, enormous, enormous_by_two_names, enormous_frames])
def test_a_file_that_reaches_beyond_itself_is_refused(tmp_path, trick):
    """Other files through links and external storage, and the memory through empty tables of any size."""
    path = Path(shutil.copy(FROZEN[-1], tmp_path / "run.vtkhdf"))
    (tmp_path / "secret").write_bytes(b"1234")
    with h5py.File(tmp_path / "other.h5", "w") as other:
        other["secret"] = np.arange(4, dtype=np.uint8)
    with h5py.File(path, "r+") as h5:
        trick(h5, tmp_path)
    with pytest.raises(InputError, match=r"elsewhere|another file|of memory|where the file has none|does not fit"):
        Run(path).frame(2)
