"""`snowmpm micro` from outside: what it writes, and how it refuses."""

import json
import subprocess
import sys

import numpy as np
import pytest

import snowmpm
from snowmpm.cli.app import app
from snowmpm.errors import InputError
from snowmpm.micro.sample import Sample
from snowmpm.micro.study import anisotropy_remark, examine, unit_doubt
from tests.support.spheres import simple_cubic
from tests.support.voxel_files import write

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


@pytest.mark.parametrize("ending", [".npy", ".npz", ".tif", ".mhd", ".mha", ".raw"])
def test_every_format_is_the_same_sample(ending, tmp_path):
    ice = np.zeros((5, 6, 7), np.uint8)
    ice[1:3, 2:, :4] = ice[0, 0, 6] = 1
    path = write(ice, tmp_path / f"sample{ending}")
    np.testing.assert_array_equal(Sample.read(path, 1e-4, counts=ice.shape).ice, ice == 1)


def damaged(name, folder):
    """Files that are no sample of snow."""
    ice = simple_cubic(8, 0.343)[0].astype(np.uint8)
    path = write(ice, folder / name)
    if name.startswith("half"):
        path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    elif name.startswith("empty"):
        path.write_bytes(b"")
    elif name.startswith("ice"):
        write(np.ones((8, 8, 8), np.uint8), path)
    elif name == "flat.npz":
        np.savez(path, ice[0])
    elif name == "enormous.mhd":
        path.write_text(path.read_text().replace("8 8 8", "9000 9000 9000"))
        with open(folder / "enormous_voxels.raw", "wb") as file:
            file.truncate(9000**3 + 3)


@pytest.mark.parametrize("name, said", [
    ("half.npy", "too short"), ("half.npz", "cannot be read"), ("half.tif", "half.tif"), ("half.mha", "holds"),
    ("half.raw", "holds 256"), ("empty.npy", "cannot be read"), ("empty.npz", "cannot be read"),
    ("empty.tif", "cannot be read"), ("empty.mhd", "no MetaImage"), ("empty.raw", "holds 0"), ("flat.npz", "3 axes"),
    ("ice.tif", "every voxel"), ("enormous.mhd", "of memory, and"),
])
def test_damaged_empty_and_enormous_images_are_refused(name, said, tmp_path, monkeypatch, capsys):
    """Two lines at most, exit code 2, nothing written; the enormous one before its 729 GB are read."""
    damaged(name, tmp_path)
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SystemExit) as end:
        app(["micro", name, "--voxel-size", "1e-4", *(["--counts", "8,8,8"] if name.endswith(".raw") else [])])
    words = capsys.readouterr().err
    assert end.value.code == 2 and said in words and len(words.strip().splitlines()) <= 2, words
    assert not (tmp_path / "runs").exists()


@pytest.mark.parametrize("free, said", [(1e4, "8 x 8 x 8 voxels"), (40_000, "the pores of the image")])
def test_memory_is_asked_for_before_it_is_taken(free, said, tmp_path, monkeypatch):
    """First that of the geometry, then that of the flow."""
    monkeypatch.setattr("snowmpm.memory.available", lambda: free)
    path = write(simple_cubic(8, 0.125)[0].astype(np.uint8), tmp_path / "spheres.npy")
    with pytest.raises(InputError, match=said) as refused:
        examine(Sample.read(path, 1e-4))
    assert "coarser voxels" in str(refused.value)


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
