"""`snowmpm micro` from outside: what it writes, and how it refuses."""

import json
import subprocess
import sys

import numpy as np
import pytest

from tests.support.spheres import simple_cubic


def micro(*arguments, cwd):
    return subprocess.run([sys.executable, "-m", "snowmpm", "micro", *map(str, arguments)], cwd=cwd,
                          capture_output=True, text=True, timeout=300, check=False)


def test_it_writes_numbers_and_a_picture(tmp_path):
    ice, radius = simple_cubic(20, 0.343)
    np.save(tmp_path / "spheres.npy", ice.astype(np.uint8))
    done = micro("spheres.npy", "--voxel-size", 1e-4, "--axes", "z", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    folder = tmp_path / "runs" / "micro_spheres"
    record = json.loads((folder / "micro.json").read_text())
    assert record["permeability"][2][2] / (1e-4 * radius) ** 2 == pytest.approx(0.04207, rel=0.1)
    assert (folder / "flow.png").stat().st_size > 5000 and "Calonne" in done.stdout


@pytest.mark.parametrize("arguments, said", [
    (["nothing.npy", "--voxel-size", 1e-4], "nothing.npy"),
    (["spheres.npy", "--voxel-size", 0], "--voxel-size"),
    (["spheres.npy", "--voxel-size", 1e-4, "--phase", 7], "--phase"),
    (["spheres.npy", "--voxel-size", 1e-4, "--axes", "w"], "--axes"),
    (["text.npy", "--voxel-size", 1e-4], "text.npy"),
    (["image.raw", "--voxel-size", 1e-4], "counts"),
])
def test_bad_samples_are_refused_in_two_lines(tmp_path, arguments, said):
    np.save(tmp_path / "spheres.npy", simple_cubic(8, 0.343)[0].astype(np.uint8))
    (tmp_path / "text.npy").write_text("no image")
    (tmp_path / "image.raw").write_bytes(b"0101")
    done = micro(*arguments, cwd=tmp_path)
    assert done.returncode == 2 and said in done.stderr and len(done.stderr.strip().splitlines()) <= 2
    assert not (tmp_path / "runs").exists()
