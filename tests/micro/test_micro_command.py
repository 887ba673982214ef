"""`snowmpm micro` from outside: what it writes, and how it refuses."""

import json
import subprocess
import sys

import numpy as np
import pytest

import snowmpm
from snowmpm.micro.study import anisotropy_remark, unit_doubt
from tests.support.spheres import simple_cubic

NO_NUMBERS = {"sample", "program", "remarks", "units", "sources"}


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
    assert (folder / "flow.png").stat().st_size > 5000 and "10.5194/tc-6-939-2012" in done.stdout
    assert record["units"]["permeability"] == "m2" and record["units"].keys() >= record.keys() - NO_NUMBERS
    assert record["program"] == f"snowmpm {snowmpm.__version__}" and "Calonne" in str(record["sources"])
    assert record["permeability_calonne_scatter"] == 1.5 and "m²/m³ of snow" in done.stdout
    assert "warning" not in done.stderr  # 26 m2/kg is that of snow


def test_a_voxel_size_in_millimetres_is_not_taken_without_a_word():
    """As a sample of 0.05 mm voxels, given 0.05."""
    right = ": --voxel-size 5e-05"
    for scale, unit in ((1.0, None), (1e3, f"millimetres{right}"), (1e6, f"micrometres{right}")):
        said = unit_doubt(10.0 / scale, 5e-5 * scale)
        assert said is None if unit is None else said.endswith(f"was likely meant in {unit}")
    assert "--phase" in unit_doubt(500.0, 5e-5)


def test_axes_that_differ_are_told_from_chance_by_the_number_of_grains():
    assert anisotropy_remark({"spread_of_axes": 0.1, "grains": 5.0}) is None
    assert "too small" in anisotropy_remark({"spread_of_axes": 0.5, "grains": 11.0})
    assert "has a direction" in anisotropy_remark({"spread_of_axes": 0.5, "grains": 400.0})


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
