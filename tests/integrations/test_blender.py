"""The add-on for Blender: what it reads, everywhere; in Blender itself, where there is one.

Blender is taken from a Python that has the wheels bpy and h5py: this one, or the one that BLENDER_PYTHON names.
"""

import importlib.util
import json
import os
import subprocess
import sys

import h5py
import numpy as np
import pytest

from snowmpm.io import Run, RunWriter
from snowmpm.render.export import export_run
from tests.render import synthetic_runs
from tests.support.project import ROOT

ADDON = ROOT / "integrations" / "blender"


def load(name):
    """A module of the add-on by its file, without Blender."""
    found = importlib.util.spec_from_file_location(f"addon_{name}", ADDON / "snowmpm_run" / f"{name}.py")
    module = importlib.util.module_from_spec(found)
    sys.modules[found.name] = module
    found.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def run_file():
    return load("run_file")


@pytest.fixture(scope="module")
def space(tmp_path_factory):
    path = tmp_path_factory.mktemp("space")
    synthetic_runs.slab_3d(path, particles=2000, frames=4, origin=(6.0e5, 2.0e5, 1.5e3), obstacles=True)
    return path


@pytest.fixture(scope="module")
def moving(tmp_path_factory):
    """Particles with numbers, in another order in each frame, which set off one after another."""
    path, rng = tmp_path_factory.mktemp("moving"), np.random.default_rng(1)
    start = rng.random((200, 3)) * [4.0, 4.0, 1.0]
    with RunWriter(path, provenance={"particle_spacing": 0.3, "scene_name": "slab"}) as writer:
        for time in (0.0, 1.0, 2.0):
            order = rng.permutation(200).astype(np.int32)
            speed = np.where(order < 100 * time, 2.0, 0.0)
            velocity = np.column_stack([speed, np.zeros((200, 2))])
            writer.frame(time, start[order] + [time, 0.0, 0.0], {"id": order, "velocity": velocity,
                                                                "density": np.full(200, 300.0)})
    return path


def test_the_run_file_is_read_as_the_program_does(run_file, space):
    mine, run = run_file.RunFile(str(space)), Run(space)
    assert np.array_equal(mine.times, run.times) and mine.name == run.name
    np.testing.assert_allclose(mine.ground[0], run.terrain.vertices)
    assert np.array_equal(mine.ground[1], run.terrain.facets)
    for i in (0, 3):
        frame, snow = run.frame(i), mine.snow(i)
        np.testing.assert_allclose(snow.points, frame.points, atol=1e-3)
        np.testing.assert_allclose(snow.attributes["velocity"], frame.fields["velocity"])
        np.testing.assert_allclose(snow.attributes["speed"], np.linalg.norm(frame.fields["velocity"], axis=1),
                                   rtol=1e-6)
    mast, house = mine.solids["mast"], mine.solids["house"]
    assert mast.moves and not house.moves
    np.testing.assert_allclose(mast.vertices @ mast.rotation[2].T + mast.translation[2],
                               run.obstacles["mast"].placed(2))
    assert mine.frame_at(-1.0) == 0 and mine.frame_at(mine.times[2]) == 2 and mine.frame_at(1e9) == 3
    assert len(mine.action()) > 100


def test_order_age_and_motion_between_frames(run_file, moving):
    mine = run_file.RunFile(str(moving / "run.vtkhdf"))
    for i, time in enumerate(mine.times):
        snow = mine.snow(i)
        assert np.array_equal(snow.attributes["id"], np.arange(200))
        set_off = np.where(np.arange(200) < 100, 1.0, 2.0)
        assert snow.attributes["age"] == pytest.approx(np.maximum(time - set_off, 0.0))
    between = mine.snow(1, 1.25)
    moved = between.points[:, 0] - mine.snow(1).points[:, 0]
    assert moved == pytest.approx(np.where(np.arange(200) < 100, 0.5, 0.0), abs=1e-6)
    assert mine.snow(2, 99.0).points == pytest.approx(mine.snow(2).points)  # nothing is known after the last


def test_columns_become_piles(run_file, tmp_path):
    depth = np.array([0.2, 1.0])
    with RunWriter(tmp_path, provenance={"particle_spacing": 0.3}) as writer:
        writer.frame(0.0, np.array([[0.0, 0.0, 0.1], [1.0, 0.0, 0.5]]), {"depth": depth})
    snow = run_file.RunFile(str(tmp_path)).snow(0)
    for x, height in ((0.0, 0.2), (1.0, 1.0)):
        pile = snow.points[snow.points[:, 0] == x, 2]
        assert (pile.min(), pile.max()) == pytest.approx((0.0, height), abs=1e-6)
        assert np.diff(np.sort(pile)).max() <= 0.3


def test_what_is_no_run_is_refused_in_a_sentence(run_file, tmp_path):
    with pytest.raises(ValueError, match="holds no run"):
        run_file.RunFile(str(tmp_path))
    with h5py.File(tmp_path / "run.vtkhdf", "w") as file:
        file["x"] = 1
    with pytest.raises(ValueError, match="is not a run of snowmpm"):
        run_file.RunFile(str(tmp_path))
    section = tmp_path / "section"
    synthetic_runs.slab_2d(section, spacing=0.5, frames=2)
    with pytest.raises(ValueError, match="a section"):
        run_file.RunFile(str(section))


@pytest.fixture(scope="module")
def blender():
    """A function that runs text in Blender's Python and returns what it prints last, from JSON."""
    python = os.environ.get("BLENDER_PYTHON") or (sys.executable if importlib.util.find_spec("bpy") else None)
    if python is None:
        pytest.skip("no Blender: BLENDER_PYTHON names a Python with the wheels bpy and h5py")

    def call(text, folder):
        head = f"import sys, json, bpy\nsys.path.insert(0, {str(ADDON)!r})\n"
        tail = "\nsys.stdout.flush(); import os; os._exit(0)"  # Blender may crash when Python takes it down
        done = subprocess.run([python, "-c", head + text + tail], capture_output=True, text=True, cwd=folder,
                              timeout=600, env={**os.environ, "PYTHONPATH": ""})
        assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-2000:]
        return json.loads(done.stdout.strip().splitlines()[-1])

    return call


READ_USD = """
bpy.ops.wm.read_homefile(use_factory_startup=True)
for one in list(bpy.data.objects):
    bpy.data.objects.remove(one)
bpy.ops.wm.usd_import(filepath="run.usdc")
scene, found = bpy.context.scene, {}
found["range"] = [scene.frame_start, scene.frame_end]
scene.frame_set(12)
graph = bpy.context.evaluated_depsgraph_get()
for one in bpy.data.objects:
    made = one.evaluated_get(graph)
    about = {"type": one.type, "place": list(made.matrix_world.translation)}
    if hasattr(made.data, "attributes"):
        about["attributes"] = {a.name: [list(v.vector) for v in a.data][:4] if a.data_type == "FLOAT_VECTOR"
                               else len(a.data) for a in made.data.attributes}
    if one.type == "MESH":
        about["materials"] = [m.name for m in made.data.materials]
    if one.type == "LIGHT":
        about["energy"] = one.data.energy
    if one.type == "CAMERA":
        about["lens"] = [one.data.lens, one.data.sensor_width]
    found[one.name] = about
print(json.dumps(found))
"""


def test_usd_opens_in_blender_as_a_lighting_artist_expects(blender, moving, space, tmp_path):
    pytest.importorskip("pxr")
    export_run(Run(moving), tmp_path, "usd", speed=0.5, fps=6.0)
    found = blender(READ_USD, tmp_path)
    assert found["range"] == [0, 24] and found["snow"]["type"] == "POINTCLOUD"
    # Frame 12 is 1 s of the run, at half its speed: blurred by 1 m/s, not by the 2 m/s of the snow
    velocity = np.array(found["snow"]["attributes"]["velocity"])
    assert velocity[:, 0] == pytest.approx(1.0) and {"radius", "density", "run_velocity"} <= set(
        found["snow"]["attributes"])
    export_run(Run(space), tmp_path / "surface", "usd", surface=True, fps=6.0)
    found = blender(READ_USD, tmp_path / "surface")
    assert found["snow"]["materials"] == ["snow"] and found["ground"]["materials"] == ["ground"]
    assert found["house"]["materials"] == ["obstacle"]
    assert "density" not in found["snow"]["attributes"] and "velocity" in found["snow"]["attributes"]
    assert found["camera"]["lens"][1] == pytest.approx(36.0) and 20.0 < found["camera"]["lens"][0] < 200.0
    assert 0.5 < found["sun"]["energy"] < 20.0


OPEN_RUN = """
from snowmpm_run import snow, nodes
bpy.ops.wm.read_factory_settings(use_empty=True)
mesh = snow.open_run(FOLDER, speed=0.5, fps=10.0)
scene, found = bpy.context.scene, {}
scene.frame_set(25)
found["fps"] = scene.render.fps / scene.render.fps_base
found["range"] = [scene.frame_start, scene.frame_end]
found["objects"] = {one.name: one.type for one in bpy.data.objects}
found["x"] = [v.co[0] for v in mesh.vertices]
found["age"] = [v.value for v in mesh.attributes["age"].data]
found["velocity"] = [v.vector[0] for v in mesh.attributes["velocity"].data]
graph = bpy.context.evaluated_depsgraph_get()
surface = bpy.data.objects["slab surface"].evaluated_get(graph).data
found["surface"] = [len(surface.vertices), sorted(a.name for a in surface.attributes if not a.name.startswith("."))]
print(json.dumps(found))
"""


def test_the_add_on_opens_a_run_folder(blender, run_file, moving, tmp_path):
    found = blender(OPEN_RUN.replace("FOLDER", repr(str(moving))), tmp_path)
    assert found["fps"] == pytest.approx(10.0) and found["range"] == [0, 40]
    mine = run_file.RunFile(str(moving)).snow(1, 1.25)  # frame 25 of 10 a second, at half the speed
    assert found["x"] == pytest.approx(mine.points[:, 0].tolist(), abs=1e-5)
    assert found["age"] == pytest.approx(mine.attributes["age"].tolist())
    assert found["velocity"] == pytest.approx((0.5 * mine.attributes["velocity"][:, 0]).tolist(), abs=1e-6)
    assert found["objects"]["camera"] == "CAMERA" and found["objects"]["sun"] == "LIGHT"
    assert found["surface"][0] > 100 and {"velocity", "speed", "density", "age"} <= set(found["surface"][1])


def test_a_still_is_rendered(blender, space, tmp_path):
    def film(run, *words):
        command = [os.environ.get("BLENDER_PYTHON") or sys.executable, str(ADDON / "film.py"), str(run), "-o", *words]
        return subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, timeout=600,
                              env={**os.environ, "PYTHONPATH": ""})

    done = film(space, "still.png", "--size", "96x54", "--samples", "1", "--draw", "surface,clods,powder")
    assert done.returncode == 0, done.stderr[-2000:]
    from PIL import Image

    picture = np.asarray(Image.open(tmp_path / "still.png").convert("RGB"))
    assert picture.shape == (54, 96, 3) and picture.std() > 3.0
    refused = film(tmp_path, "a.png")
    assert refused.returncode == 1 and "error: " in refused.stderr and "Traceback" not in refused.stderr
