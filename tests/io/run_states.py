"""States of a made-up run, each a known function of its frame number, so that a reader can tell whether it is whole."""

import numpy as np

from snowmpm.io import RunWriter

UNITS = {"velocity": "m/s", "density": "kg/m3", "stress": "Pa", "material": ""}
ORIGIN = (5.0e5, 2.0e5, 1.0e3)


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


def loads(i, dimension=3):
    """Rows of the loads on an obstacle before frame `i`: two of them, none before the first frame."""
    times = np.array([i - 0.5, i]) * 0.1 if i else np.zeros(0)
    force = np.outer(times, np.arange(1.0, 1.0 + dimension))
    return {"time": times, "force": force, "moment": force if dimension == 3 else times, "impulse": 2.0 * force,
            "work": 3.0 * times}


def pose(i, dimension=3):
    """Rotation and translation of the obstacle in frame `i`."""
    c, s = np.cos(0.1 * i), np.sin(0.1 * i)
    rotation = np.eye(dimension)
    rotation[np.ix_([0, -1], [0, -1])] = [[c, -s], [s, c]]
    return rotation, np.full(dimension, 0.5 * i)


def new_writer(path, **options):
    terrain = (np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0.5]]), np.array([[0, 1, 2]]))
    settings = dict(
        provenance={"scene": "made up", "seed": 1},
        terrain=terrain,
        obstacles={"wall": terrain},
        origin=ORIGIN,
        dimension=3,
        units=UNITS,
        durable=False,
    )
    return RunWriter(path, **{**settings, **options})


def write_frame(writer, i, n):
    points, fields = state(i, n)
    writer.history(i * 0.1, {"mass": 2.0, "front": float(i)}, {"mass": "kg", "front": "m"})
    writer.frame(i * 0.1, points, fields, {"wall": pose(i)}, {"wall": loads(i)})


def assert_frame(run, i, n):
    """Frame i is the one that was written, bit for bit."""
    points, fields = state(i, n)
    frame = run.frame(i)
    assert run.times[i] == i * 0.1
    assert np.array_equal(frame.points, points)
    assert set(frame.fields) == set(fields)
    for name, values in fields.items():
        assert np.array_equal(frame.fields[name], values), name


def assert_whole(run, n):
    """Every frame that the run shows is the one that was written, bit for bit."""
    for i in range(len(run)):
        assert_frame(run, i, n)
    wall = run.obstacles["wall"]
    for name in loads(0):
        written = np.concatenate([loads(0)[name], *(loads(i)[name] for i in range(1, len(wall.rotation)))])
        assert np.array_equal(getattr(wall, name), written), name
    assert len(run) <= len(wall.rotation) == len(wall.translation)
    for i in range(len(run)):
        assert np.array_equal(wall.rotation[i], pose(i)[0]) and np.array_equal(wall.translation[i], pose(i)[1])
