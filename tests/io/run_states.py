"""States of a made-up run, each a known function of its frame number, so that a reader can tell whether it is whole."""

import numpy as np

from snowmpm.io import RunWriter

UNITS = {"velocity": "m/s", "density": "kg/m3", "stress": "Pa", "material": ""}


def n_points(i, n):
    """Particles leave and come back: every third frame has fewer, every fifth more."""
    return n - 7 * (i % 3 == 1) + 300 * (i % 5 == 4)


def state(i, n):
    rng = np.random.default_rng(i)
    m = n_points(i, n)
    points = rng.random((m, 3), dtype=np.float32) + np.float32(i)
    return points, {
        "velocity": points * np.float32(0.5),
        "density": points[:, 0] * np.float32(100.0),
        "stress": np.repeat(points, 2, axis=1),
        "material": np.arange(m, dtype=np.int32) % 3,
    }


def new_writer(path, **options):
    terrain = (np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0.5]]), np.array([[0, 1, 2]]))
    settings = dict(
        provenance={"scene": "made up", "seed": 1},
        terrain=terrain,
        origin=(5.0e5, 2.0e5, 1.0e3),
        dimension=3,
        units=UNITS,
        durable=False,
    )
    return RunWriter(path, **{**settings, **options})


def write_frame(writer, i, n):
    points, fields = state(i, n)
    writer.history(i * 0.1, {"mass": 2.0, "front": float(i)}, {"mass": "kg", "front": "m"})
    writer.frame(i * 0.1, points, fields)


def assert_whole(run, n):
    """Every frame that the run shows is the one that was written, bit for bit."""
    for i in range(len(run)):
        points, fields = state(i, n)
        frame = run.frame(i)
        assert run.times[i] == i * 0.1
        assert np.array_equal(frame.points, points)
        assert set(frame.fields) == set(fields)
        for name, values in fields.items():
            assert np.array_equal(frame.fields[name], values), name
