"""A resumed run needs the files that it began with: every one that the scene names, and those that belong to it."""

import json
import shutil

import numpy as np
import pytest

import snowmpm
from snowmpm.errors import InputError
from snowmpm.scenes import load_scene

GRID = "ncols 30\nnrows 12\nxllcorner 0\nyllcorner 0\ncellsize 2\nNODATA_value -9999\n"
SCENE = """name = "files"
dimension = 3
end_time = 0.4
[output]
interval = 0.2
[stop]
at_rest = false
[solver]
method = "depth"
dx = 2.0
[terrain]
kind = "dem"
file = "ground.asc"
friction = { law = "voellmy", mu = { file = "mu.asc" }, xi = 1000.0 }
entrainment = { law = "rate", growth_rate = 0.001, thickness = { file = "cover.asc" }, density = 150.0 }
[[terrain.forest]]
name = "wood"
region = { file = "wood.geojson" }
drag = 0.02
[materials.snow]
kind = "elastic"
density = 300.0
youngs_modulus = 1e5
poisson_ratio = 0.2
[[bodies]]
name = "release"
material = "snow"
shape = { kind = "layer", top = 1.0, region = { file = "release.geojson" } }
"""


def raster(path, value):
    rows = [" ".join(f"{value(i, j):g}" for j in range(30)) for i in range(12)]
    path.write_text(GRID + "\n".join(rows) + "\n", encoding="ascii")


def polygon(path, x0, x1, y0, y1):
    ring = [[x0, y0], [x1, y0], [x1, y1], [x0, y1], [x0, y0]]
    path.write_text(json.dumps({"type": "FeatureCollection", "features": [
        {"type": "Feature", "properties": {}, "geometry": {"type": "Polygon", "coordinates": [ring]}}]}))


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A run of a scene with five files, beside them."""
    folder = tmp_path_factory.mktemp("files")
    raster(folder / "ground.asc", lambda i, j: 40.0 - 0.9 * j)
    raster(folder / "mu.asc", lambda i, j: 0.2)
    raster(folder / "cover.asc", lambda i, j: 0.1)
    polygon(folder / "wood.geojson", 30, 40, 4, 16)
    polygon(folder / "release.geojson", 6, 16, 6, 18)
    (folder / "scene_of_files.toml").write_text(SCENE)
    snowmpm.run(load_scene(folder / "scene_of_files.toml"), folder / "run")
    return folder


def longer(folder):
    return load_scene(folder / "scene_of_files.toml", {"end_time": 0.6})


FILES = {"terrain.file": "ground.asc", "terrain.friction.mu.file": "mu.asc",
         "terrain.entrainment.thickness.file": "cover.asc", "terrain.forest.0.region.file": "wood.geojson",
         "bodies.0.shape.region.file": "release.geojson"}


@pytest.mark.parametrize("key", FILES)
def test_a_changed_file_is_refused_by_its_name(folder, tmp_path, key):
    shutil.copytree(folder, tmp_path / "copy")
    path = tmp_path / "copy" / FILES[key]
    text = path.read_text()
    # The same file in other words is another file too: nobody can tell what a program makes of it
    path.write_text(text + "\n")
    with pytest.raises(InputError, match=f"{key}: {FILES[key]} is not what it was when the run began"):
        snowmpm.run(longer(tmp_path / "copy"), tmp_path / "copy" / "run", resume=True)


def test_unchanged_files_elsewhere_will_do(folder, tmp_path):
    shutil.copytree(folder, tmp_path / "copy")
    run = snowmpm.run(longer(tmp_path / "copy"), tmp_path / "copy" / "run", resume=True)
    assert run.complete and run.times[-1] == pytest.approx(0.6)


def test_what_belongs_to_a_file_counts_as_it(folder, tmp_path):
    """A file of projection or statistics that appears beside one may change what is read."""
    shutil.copytree(folder, tmp_path / "copy")
    (tmp_path / "copy" / "ground.asc.aux.xml").write_text("<PAMDataset/>")
    with pytest.raises(InputError, match=r"terrain\.file: ground\.asc is not what it was"):
        snowmpm.run(longer(tmp_path / "copy"), tmp_path / "copy" / "run", resume=True)
    assert np.isfinite(snowmpm.open_run(tmp_path / "copy" / "run").times).all()
