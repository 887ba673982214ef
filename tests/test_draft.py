"""What cannot be written to its end is not there, and the reason names the file: pictures, films, rasters, tables."""

import contextlib
import errno
import resource
import signal

import numpy as np
import pytest
from matplotlib.figure import Figure

from snowmpm.draft import draft, write_table, write_text
from snowmpm.io.geotiff import write_geotiff
from snowmpm.io.ground_maps import Map
from snowmpm.render.figure import save
from snowmpm.render.film import open_film


@contextlib.contextmanager
def no_room():
    """Files may not grow beyond 3 kB: to who writes them this is like a full disk, also to ffmpeg. Inside a test only:
    pytest writes what it has to say, perhaps to a file, before it takes fixtures down."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    handler = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (3000, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
        signal.signal(signal.SIGXFSZ, handler)


def film(path):
    rng = np.random.default_rng(1)
    with open_film(path, 10.0) as show:
        for _ in range(4):
            show(rng.integers(0, 255, (64, 64, 3), dtype=np.uint8))
    return path


def raster(path):
    values = np.random.default_rng(1).random((60, 50), np.float32)
    return write_geotiff(path, Map(values, 0.5, 0.5, 1.0, "m"), np.zeros(3))


def table(path):
    return write_table(path, ["a", "b"], [[i, 1.0 / (1 + i)] for i in range(1000)])


def plot(path):
    figure = Figure()
    figure.add_subplot().plot([1.0, 3.0, 2.0])
    return save(figure, path, 100)


WRITERS = {"film.mp4": film, "film.gif": film, "picture.png": film, "map.tif": raster, "table.csv": table,
           "page.html": lambda path: write_text(path, "x" * 4000), "plot.png": plot}


@pytest.mark.parametrize("name", WRITERS)
def test_written_whole(tmp_path, name):
    path = tmp_path / "new" / name
    assert WRITERS[name](path) == path
    assert [file.name for file in path.parent.iterdir()] == [name] and path.stat().st_size > 3000


@pytest.mark.parametrize("name", WRITERS)
def test_not_written(tmp_path, name):
    path = tmp_path / name
    path.write_bytes(b"the one before")
    with no_room(), pytest.raises(OSError, match=rf"\[Errno \d+\] [^\n]+: '.*/{name}'") as failure:
        WRITERS[name](path)
    assert not isinstance(failure.value, BrokenPipeError)  # which the commands take for a reader who has seen enough
    assert path.read_bytes() == b"the one before" and list(tmp_path.iterdir()) == [path]


def test_a_folder_of_frames_has_whole_ones(tmp_path):
    with (no_room(), pytest.raises(OSError, match=r"frame_00001\.png"),
          open_film(tmp_path / "frames", 10.0) as show):
        show(np.zeros((8, 8, 3), np.uint8))
        show(np.random.default_rng(1).integers(0, 255, (64, 64, 3), dtype=np.uint8))
    assert [file.name for file in (tmp_path / "frames").iterdir()] == ["frame_00000.png"]


def test_errors_of_other_files_keep_their_names(tmp_path):
    with pytest.raises(FileNotFoundError, match=r"other\.txt"), draft(tmp_path / "a.txt"):
        (tmp_path / "other.txt").read_text()
    (tmp_path / "file").touch()
    with pytest.raises(OSError) as failure:
        write_text(tmp_path / "file" / "a.txt", "text")
    assert failure.value.errno in (errno.EEXIST, errno.ENOTDIR)


def test_interrupted(tmp_path):
    with pytest.raises(KeyboardInterrupt), draft(tmp_path / "a.txt") as part:
        part.touch()
        raise KeyboardInterrupt
    assert not list(tmp_path.iterdir())
