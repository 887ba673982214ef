"""Meshes, rasters, regions, voxel images and run files with changed bytes: they are read, or refused with a reason."""

import json
import random
import shutil
from pathlib import Path

import numpy as np
import pytest
import trimesh

from snowmpm import Run
from snowmpm.errors import InputError
from snowmpm.io import RunWriter
from tests.support.slope_scene import RING, SCENE, raster_text, slope_scene

WORDS = [b"nan", b"inf", b"-1", b"0", b"1e308", b"1e-308", b"99999999999999999999", b"4294967295", b"x", b"", b"[",
         b"{", b"null", b"-9999", b"2147483648", b"\x00", b"\xff\xfe"]


def scene_of(file, dx=1.0):
    """A scene that takes its terrain, its region or its body from this file."""
    kind = {".asc": "dem", ".tif": "dem", ".geojson": "region", ".shp": "region", ".npz": "voxels", ".npy": "voxels",
            ".tiff": "voxels"}.get(Path(file).suffix, "mesh")
    if kind == "voxels":
        shape = f'{{ kind = "voxels", file = "{file}", voxel_size = 0.5, phase = 1 }}'
        return SCENE.format(shape=shape, dx=0.5, end_time=0.1)
    if kind == "region":
        return slope_scene("good.obj", region=f'{{ file = "{file}" }}', dx=dx, end_time=0.1)
    return slope_scene(file, kind, dx=dx, end_time=0.1)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Folder with one good file of each kind."""
    folder = tmp_path_factory.mktemp("files")
    x, y = np.meshgrid(np.linspace(0.0, 10.0, 6), np.linspace(0.0, 10.0, 6), indexing="ij")
    points = np.column_stack([x.ravel(), y.ravel(), (5.0 - 0.4 * x + 0.1 * y).ravel()])
    i = np.arange(30).reshape(5, 6)[:, :5].ravel()
    slope = trimesh.Trimesh(points, np.concatenate([np.stack([i, i + 6, i + 7], 1), np.stack([i, i + 7, i + 1], 1)]),
                            process=False)
    slope.export(folder / "good.stl")
    (folder / "ascii.stl").write_text(trimesh.exchange.stl.export_stl_ascii(slope))
    slope.export(folder / "good.obj")
    slope.export(folder / "good.ply")
    (folder / "ascii.ply").write_bytes(trimesh.exchange.ply.export_ply(slope, encoding="ascii"))
    heights = [[5 - 0.4 * i + 0.01 * j for i in range(12)] for j in range(12)]
    (folder / "good.asc").write_text(raster_text(heights))
    polygon = {"type": "Polygon", "coordinates": [RING]}
    feature = {"type": "Feature", "properties": {"thickness": 2.0}, "geometry": polygon}
    (folder / "good.geojson").write_text(json.dumps({"type": "FeatureCollection", "features": [feature]}))
    voxels = np.zeros((8, 8, 8), np.uint8)
    voxels[2:6, 2:6, 2:6] = 1
    np.save(folder / "good.npy", voxels)
    np.savez_compressed(folder / "good.npz", voxels)
    rasterio, shapefile = pytest.importorskip("rasterio"), pytest.importorskip("shapefile")
    with rasterio.open(folder / "good.tif", "w", driver="GTiff", width=12, height=12, count=1, dtype="float32",
                       transform=rasterio.transform.from_origin(0, 12, 1, 1), compress="deflate") as raster:
        raster.write(np.tile(np.linspace(5, 1, 12, dtype=np.float32), (12, 1)), 1)
    with shapefile.Writer(str(folder / "good")) as writer:
        writer.field("thickness", "N", decimal=2)
        writer.poly([RING[::-1]])
        writer.record(2.0)
    return folder


def mutated(content, dice, text):
    """The bytes with one to four changes: bits, words, cuts, repeats; of a text mostly words."""
    content = bytearray(content)
    for _ in range(dice.randint(1, 4)):
        if not content:
            break
        at = dice.randrange(len(content))
        # Headers are short, and what is in them matters most
        at = at if dice.random() < 0.6 else dice.randrange(min(len(content), 200))
        change = dice.choice("wwwcrd" if text else "bbibwcr")
        if change == "b":
            content[at] ^= 1 << dice.randrange(8)
        elif change == "i":
            content[at : at + 4] = dice.choice([0, 1, 0x7FFFFFFF, 0xFFFFFFFF, 0x80000000]).to_bytes(4, "little")
        elif change == "w":
            end = next((k for k in range(at, len(content)) if content[k : k + 1].isspace()), at + 1)
            content[at:end] = dice.choice(WORDS)
        elif change == "c":
            del content[at : at + dice.choice([1, 7, 100, len(content)])]
        elif change == "r":
            content[at:at] = content[at : at + dice.choice([1, 4, 80])] * dice.choice([1, 50])
        else:
            content[at:at] = b"\n"
    return bytes(content)


GOOD = ("good.stl", "ascii.stl", "good.obj", "good.ply", "ascii.ply", "good.asc", "good.tif", "good.geojson",
        "good.shp", "good.dbf", "good.shx", "good.npy", "good.npz")
TEXT = (".obj", ".asc", ".geojson")


def test_the_files_themselves_are_accepted(ended_well, folder):
    for name in GOOD:
        scene = folder / "scene.toml"
        scene.write_text(scene_of(name.replace(".dbf", ".shp").replace(".shx", ".shp")))
        assert ended_well("check", scene) == 0, name


@pytest.mark.parametrize("count", [3, pytest.param(120, marks=pytest.mark.slow)])
@pytest.mark.parametrize("name", GOOD)
def test_mutated_files(ended_well, folder, tmp_path, name, count):
    dice, codes = random.Random(f"{name} {count}"), []
    shutil.copytree(folder, tmp_path, dirs_exist_ok=True)
    good = (folder / name).read_bytes()
    scene = tmp_path / "scene.toml"
    scene.write_text(scene_of(name.replace(".dbf", ".shp").replace(".shx", ".shp")))
    for _ in range(count):
        (tmp_path / name).write_bytes(mutated(good, dice, Path(name).suffix in TEXT or name.startswith("ascii")))
        codes.append(ended_well("check", scene))
    print(f"{name}: {codes.count(0)} accepted, {codes.count(2)} refused")


@pytest.fixture(scope="module")
def run_file(tmp_path_factory):
    """A run file of 3-D with everything in it."""
    path = tmp_path_factory.mktemp("good") / "run.vtkhdf"
    rng = np.random.default_rng(1)
    terrain = (np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0.5]]), np.array([[0, 1, 2]]))
    with RunWriter(path, provenance={"scene": "made up"}, terrain=terrain, obstacles={"wall": terrain},
                   units={"velocity": "m/s"}) as writer:
        for i in range(3):
            points = rng.random((200, 3))
            writer.history(0.1 * i, {"mass": 2.0}, {"mass": "kg"})
            writer.frame(0.1 * i, points, {"velocity": points, "density": points[:, 0]})
        writer.map("peak_depth", rng.random((4, 5)), 0.0, 0.0, 1.0, "m")
    return path


def read_all(path):
    """Everything that a run file holds."""
    run = Run(path)
    for i in range(min(len(run), 5)):
        run.frame(i)
    return run.terrain, run.maps, run.obstacles, run.hazard, run.provenance, run.saw_test


@pytest.mark.parametrize("count", [40, pytest.param(600, marks=pytest.mark.slow)])
def test_mutated_run_files(ended_well, run_file, tmp_path, count):
    dice, good, path = random.Random(count), run_file.read_bytes(), tmp_path / "run.vtkhdf"
    codes, refused = [], 0
    for _ in range(count):
        path.write_bytes(mutated(good, dice, text=False))
        codes.append(ended_well("info", path))
        try:
            read_all(path)
        except InputError:
            refused += 1
    print(f"{codes.count(0)} shown, {codes.count(2)} refused by info; {refused} refused when all is read")
    assert codes.count(2) and refused
