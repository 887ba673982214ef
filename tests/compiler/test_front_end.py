"""Kernels that the compiler is told from the disk: the same ones, without going through their source."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from snowmpm.compiler import front_end, patches

STEPS = """
import json, sys
import numpy as np
from snowmpm import Simulation, load_scene
from snowmpm.compiler.backend import part

kernels, gone_through = part("lang.kernel_impl").Kernel, []
kept = kernels.materialize
def materialize(self, *args, **named):
    gone_through.append(self.func.__name__)
    return kept(self, *args, **named)
kernels.materialize = materialize
simulation = Simulation(load_scene(sys.argv[1], json.loads(sys.argv[2])))
for _ in range(20):
    simulation.step()
fields = simulation.particles
print(json.dumps({"gone_through": gone_through, "bits": fields["position"].tobytes().hex()}))
"""


COLUMN = "column_collapse_2d", {"solver.dx": 0.05}
TRIED = {"nested", "third", "double", "meet"}
"""Kernels of `compiler.probe`, at the first start alone."""


def steps(folder, scene, values, patches="all"):
    """What twenty steps of a scene give, with kernels kept in this folder."""
    env = {**os.environ, "TI_OFFLINE_CACHE_FILE_PATH": str(folder), "SNOWMPM_PATCHES": patches}
    done = subprocess.run([sys.executable, "-c", STEPS, scene, json.dumps(values)], check=True, capture_output=True,
                          text=True, env=env)
    return json.loads(done.stdout.splitlines()[-1])


@pytest.fixture(scope="module")
def kept(tmp_path_factory):
    """Folder with the kernels of a column of 2-D, and what its steps gave."""
    folder = tmp_path_factory.mktemp("kernels")
    return folder, steps(folder, *COLUMN)


@pytest.fixture
def copied(kept, tmp_path):
    return Path(shutil.copytree(kept[0], tmp_path / "kernels")), kept[1]


def test_the_next_process_goes_through_no_source_and_has_the_same_bits(copied):
    folder, first = copied
    second = steps(folder, *COLUMN)
    assert len(first["gone_through"]) > 5
    assert second["gone_through"] == []
    assert second["bits"] == first["bits"]


@pytest.mark.slow
@pytest.mark.parametrize(("scene", "values"), [
    ("column_collapse_2d", {"solver.dx": 0.05, "solver.precision": "f64"}),
    ("column_collapse_2d", {"solver.method": "sph", "solver.dx": 0.05}),
    ("avalanche_depth_averaged", {}), ("slab_release", {}), ("slush_dam_2d", {}), ("block_wall_2d", {})])
def test_so_it_is_with_every_method(tmp_path, scene, values):
    first = steps(tmp_path, scene, values)
    second = steps(tmp_path, scene, values)
    assert (second["gone_through"], second["bits"]) == ([], first["bits"])


def test_without_the_patch_the_bits_are_the_same_and_no_file_is_written(copied):
    folder, first = copied
    for path in front_end.records(folder):
        path.unlink()
    others = ",".join(name for name in patches.GAINS if name != "front_end")
    without = steps(folder, *COLUMN, patches=others)
    assert without["bits"] == first["bits"]
    assert {*without["gone_through"]} >= {*first["gone_through"]} - TRIED
    assert front_end.records(folder) == []


def test_a_file_that_is_none_of_a_kernel_is_made_anew(copied):
    folder, first = copied
    whole = {path: path.read_bytes() for path in front_end.records(folder)}
    other = max(whole.values(), key=len)
    for k, (path, data) in enumerate(whole.items()):
        path.write_bytes((data[: len(data) // 2], b"", b"nothing", other[:-1] + b"x")[k % 4])
    second = steps(folder, *COLUMN)
    assert {*second["gone_through"]} == {*first["gone_through"]} - TRIED
    assert second["bits"] == first["bits"]
    assert steps(folder, *COLUMN)["gone_through"] == []


def test_a_record_under_another_name_or_too_large_is_none(tmp_path):
    path, told = tmp_path / f"a{front_end.ENDING}", (["expr_add"], [("int", "1", 1)], [(0, 0, 0)])
    front_end._write(path, told)
    assert front_end._read(path) == told
    assert front_end._read(path.rename(tmp_path / f"b{front_end.ENDING}")) is None
    path.write_bytes(bytes(front_end.MOST_OF_ONE + 1))
    assert front_end._read(path) is None


def test_a_file_that_cannot_be_written_leaves_nothing_behind(tmp_path):
    path = tmp_path / f"a{front_end.ENDING}"
    path.mkdir()
    front_end._write(path, ([], [], []))
    assert [one.name for one in tmp_path.iterdir()] == [path.name]


def test_the_oldest_files_give_way(tmp_path, monkeypatch):
    monkeypatch.setattr(front_end, "MOST_BYTES", 250)
    for k in range(5):
        path = tmp_path / f"{k}{front_end.ENDING}"
        path.write_bytes(bytes(100))
        os.utime(path, (k, k))
    (tmp_path / "T0.tic").write_bytes(bytes(1000))
    front_end._make_room(tmp_path)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["3.told", "4.told", "T0.tic"]
