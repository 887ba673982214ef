"""Checkpoints that are whole, with a good checksum, and yet not what the program wrote."""

import io
import json
import zipfile

import numpy as np
import pytest
from scenes_under_attack import block, copied, written

from snowmpm.io.archive import read_archive, write_archive


@pytest.fixture(scope="session")
def stopped(program, tmp_path_factory):
    """A finished run with its checkpoint, to be prolonged."""
    folder = tmp_path_factory.mktemp("stopped")
    block(folder)
    assert program.run(folder, "run", "scene.toml", "-o", "out", "-q").code == 0
    return folder


@pytest.fixture
def resumed(withstood, stopped, tmp_path):
    """resumed(change) -> the end of a run that goes on from a checkpoint whose tree was changed."""
    folder = copied(tmp_path, stopped)

    def invoke(change, **options):
        path = folder / "out" / "checkpoint.npz"
        tree = read_archive(path)
        changed = change(tree)
        write_archive(path, tree if changed is None else changed)
        return withstood("run", "scene.toml", "-o", "out", "--resume", "-q", "--set", "end_time=0.03", folder=folder,
                         **options)

    return invoke


def test_the_good_one_goes_on(resumed):
    resumed(lambda tree: None, code=0)


def at(*path, value):
    def change(tree):
        *way, last = path
        for key in way:
            tree = tree[key]
        if value is KeyError:
            del tree[last]
        else:
            tree[last] = value(tree[last]) if callable(value) else value
    return change


PARTICLES = ("simulation", "solver")
CHANGES = {
    "list": lambda tree: [1, 2], "no_format": at("format", value=KeyError), "version_text": at("version", value="x"),
    "no_scene": at("scene", value=KeyError), "scene_number": at("scene", value=5),
    "scene_words": at("scene", value="[[["), "scene_deep": at("scene", value=".".join("a" * 50_000) + " = 1"),
    "scene_digits": at("scene", value="a = " + "9" * 5000),
    "scene_less": at("scene", value="a = 1"), "scene_long": at("scene", value="#" * (5 << 20)),
    "time_text": at("time", value="soon"), "time_list": at("time", value=[1]),
    "no_terrain": at("terrain", value=KeyError),
    "no_simulation": at("simulation", value=KeyError), "simulation_list": at("simulation", value=[]),
    "no_solver": at(*PARTICLES, value=KeyError), "no_recorder": at("recorder", value=KeyError),
    "recorder_list": at("recorder", value=[]), "recorder_text": at("recorder", "frames", value="x"),
    "phases_unknown": at("phases", value={"__class__": 5}), "phases_text": at("phases", value={"setup": "x"}),
    "reals_wide": at(*PARTICLES, "reals", value=lambda a: np.zeros((len(a), 500), a.dtype)),
    "reals_flat": at(*PARTICLES, "reals", value=lambda a: a.ravel()),
    "reals_none": at(*PARTICLES, "reals", value=lambda a: a[:0]),
    "reals_nan": at(*PARTICLES, "reals", value=lambda a: np.full_like(a, np.nan)),
    "reals_far": at(*PARTICLES, "reals", value=lambda a: np.full_like(a, 1e30)),
    "reals_text": at(*PARTICLES, "reals", value="x"),
    "labels_beyond": at(*PARTICLES, "labels", value=lambda a: np.full_like(a, 200)),
    "labels_below": at(*PARTICLES, "labels", value=lambda a: np.full_like(a, -1)),
    "labels_flat": at(*PARTICLES, "labels", value=lambda a: a.ravel()),
    "start_beyond": at(*PARTICLES, "start", value=lambda a: a + 1_000_000), "start_back": at(*PARTICLES, "start",
                                                                                         value=lambda a: a[::-1]),
    "keys_beyond": at(*PARTICLES, "keys", value=lambda a: a + (1 << 61)), "keys_same": at(*PARTICLES, "keys",
                                                                                      value=lambda a: a * 0),
    "keys_few": at(*PARTICLES, "keys", value=lambda a: a[:1]), "time_nan": at(*PARTICLES, "time", value=float("nan")),
    "frame_other": at(*PARTICLES, "frame", value=[[0, 0], [1 << 40, 1 << 40]]),
    "extremes_unknown": at(*PARTICLES, "extremes", value={"x": 1}), "steps_text": at(*PARTICLES, "steps", value="x"),
    "steps_list": at(*PARTICLES, "steps", value=[1]), "extremes_text": at(*PARTICLES, "extremes", "speed", value="x"),
    "removed_text": at(*PARTICLES, "removed", "mass", value="x"),
    "work_none": at(*PARTICLES, "plastic_work", value=None),
    "mass_array": at(*PARTICLES, "mass", value=np.ones(3)), "dt_text": at("simulation", "dt", value="x"),
    "energy_text": at("simulation", "audit", "energy", value="x"),
    "reference_text": at("simulation", "audit", "reference", value="x"),
    "events_more": at("simulation", "events", value=[1, 2, 3]), "dt_below": at("simulation", "dt", value=-1.0),
    "bodies_other": at("simulation", "body_starts", value=lambda a: np.asarray(a)[:0]),
    "audit_list": at("simulation", "audit", value=[]),
}
SELDOM = {"no_terrain", "time_nan", "keys_beyond", "frame_other", "dt_below", "audit_list",
          "recorder_text"}


@pytest.mark.parametrize("name", [pytest.param(name, marks=pytest.mark.slow) if name in SELDOM else name
                                  for name in CHANGES])
def test_tree(resumed, name):
    resumed(CHANGES[name], code=(0, 2) if name in SELDOM else 2)


def npz(members, compression=zipfile.ZIP_STORED):
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", compression) as archive:
        for name, content in members.items():
            archive.writestr(name, content)
    return file.getvalue()


def npy(array):
    file = io.BytesIO()
    np.save(file, array)
    return file.getvalue()


def record(text):
    return npy(np.frombuffer(text.encode(), np.uint8))


HEAD = b"\x93NUMPY\x01\x00\x76\x00" + b"{'descr': '<f8', 'fortran_order': False, 'shape': (1000000000000,), }"
HEAD = HEAD.ljust(127) + b"\n"
ARCHIVES = {
    "empty": npz({}), "nested": npz({"record.npy": record("[" * 100_000), "digest.npy": npy(np.zeros(32, np.uint8))}),
    "no_digest": npz({"record.npy": record("{}")}), "declared": npz({"digest.npy": HEAD, "record.npy": record("{}")}),
    "deflated": lambda: npz({"record.npy": npy(np.zeros(1 << 28, np.uint8))}, zipfile.ZIP_DEFLATED),
    "objects": npz({"digest.npy": npy(np.zeros(2)).replace(b"<f8", b"|O ")}), "text": b"hello",
    "cut": npz({"a": b"1"})[:40],
    "many": lambda: npz({f"{i}.npy": b"" for i in range(20_000)}), "above": npz({"../../x.npy": record("{}")}),
    "json": npz({"record.npy": record(json.dumps({"array": "x"})), "digest.npy": npy(np.zeros(32, np.uint8))}),
}


@pytest.mark.parametrize("name", ARCHIVES)
def test_bytes(withstood, stopped, tmp_path, name):
    folder = copied(tmp_path, stopped)
    written(folder / "out" / "checkpoint.npz", ARCHIVES[name])
    withstood("run", "scene.toml", "-o", "out", "--resume", "-q", "--set", "end_time=0.03", folder=folder, code=2)
