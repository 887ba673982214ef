"""What `snowmpm export` writes, read again by other libraries: trimesh (PLY, glTF) and USD's own."""

import json
import subprocess
import sys

import numpy as np
import pytest
import synthetic_runs
import trimesh
from PIL import Image
from scipy.spatial import cKDTree

from snowmpm.errors import InputError
from snowmpm.io import Run
from snowmpm.render.export import export_run
from snowmpm.render.run_film import view_of

ORIGIN = (6.0e5, 2.0e5, 1.5e3)


@pytest.fixture(scope="module")
def space(tmp_path_factory):
    path = tmp_path_factory.mktemp("space")
    synthetic_runs.slab_3d(path, particles=2000, frames=4, origin=ORIGIN, obstacles=True)
    return Run(path)


@pytest.fixture(scope="module")
def section(tmp_path_factory):
    path = tmp_path_factory.mktemp("section")
    synthetic_runs.slab_2d(path, spacing=0.3, frames=3, obstacles=True)
    return Run(path)


def same_points(found, frame):
    np.testing.assert_array_equal(np.asarray(found, np.float32), frame.points)


def test_ply_holds_points_and_fields(space, tmp_path):
    paths = export_run(space, tmp_path, "ply", every=3)
    record = json.loads((tmp_path / "sequence.json").read_text())
    assert len(record["radii"]) == len(record["files"]) and min(record["radii"]) > 0.0
    assert record["files"] == ["snow_0000.ply", "snow_0001.ply"] and record["origin"] == list(ORIGIN)
    assert record["times"] == space.times[::3].tolist()
    assert {path.name for path in paths} >= {"ground.ply", "house.ply", "mast_0000.ply", "mast_0001.ply"}
    for file, i in zip(record["files"], (0, 3), strict=True):
        frame, snow = space.frame(i), trimesh.load(tmp_path / file, process=False)
        same_points(snow.vertices, frame)
        table = snow.metadata["_ply_raw"]["vertex"]["data"]
        for name, values in frame.fields.items():
            columns = [name] if values.ndim == 1 else [f"{name}_{axis}" for axis in "xyz"[: values.shape[1]]]
            np.testing.assert_array_equal(np.column_stack([np.ravel(table[one]) for one in columns]),
                                          values.reshape(len(frame.points), -1))
    ground = trimesh.load(tmp_path / "ground.ply", process=False)
    np.testing.assert_array_equal(ground.faces, space.terrain.facets)
    np.testing.assert_allclose(ground.vertices, space.terrain.vertices, rtol=1e-6)
    mast = trimesh.load(tmp_path / "mast_0001.ply", process=False)
    np.testing.assert_allclose(mast.vertices, space.obstacles["mast"].placed(3), rtol=1e-5, atol=1e-4)


def test_gltf_has_y_up_and_all_parts(space, tmp_path):
    paths = export_run(space, tmp_path, "gltf")
    assert [path.name for path in paths] == [f"snow_{i:04d}.glb" for i in range(4)]
    scene = trimesh.load(paths[2])
    assert set(scene.geometry) == {"snow", "ground", "house", "mast"}
    frame = space.frame(2)
    same_points(scene.geometry["snow"].vertices, frame)
    turned = scene.graph.get(next(name for name in scene.graph.nodes_geometry
                                  if scene.graph[name][1] == "snow"))[0]
    np.testing.assert_allclose(turned[:3, :3] @ [0.0, 0.0, 1.0], [0.0, 1.0, 0.0], atol=1e-6)
    text = paths[2].read_bytes()
    header = json.loads(text[20 : 20 + int.from_bytes(text[12:16], "little")])
    assert header["asset"]["extras"]["time"] == space.times[2]
    snow = next(mesh for mesh in header["meshes"] if mesh["name"] == "snow")["primitives"][0]["attributes"]
    view = header["bufferViews"][header["accessors"][snow["_VELOCITY"]]["bufferView"]]
    start = 28 + int.from_bytes(text[12:16], "little") + view["byteOffset"]
    velocity = np.frombuffer(text, "<f4", view["byteLength"] // 4, start).reshape(-1, 3)
    np.testing.assert_array_equal(velocity, frame.fields["velocity"])


def test_usd_moves_at_the_speed_of_the_film(space, tmp_path):
    Usd = pytest.importorskip("pxr.Usd")
    from pxr import UsdGeom

    path, _ = export_run(space, tmp_path, "usd", speed=2.0, fps=30.0)
    stage = Usd.Stage.Open(str(path))
    assert UsdGeom.GetStageUpAxis(stage) == "Z" and UsdGeom.GetStageMetersPerUnit(stage) == 1.0
    snow = UsdGeom.Points(stage.GetPrimAtPath("/run/snow"))
    codes = snow.GetPointsAttr().GetTimeSamples()
    held = [0.999 * 40.0 + code for code in codes[:-1:2]]  # its particles have no numbers
    np.testing.assert_allclose(codes, sorted([*(space.times / 2.0 * 30.0), *held]))
    codes = codes[::2]
    frame = space.frame(2)
    same_points(snow.GetPointsAttr().Get(codes[2]), frame)
    np.testing.assert_allclose(snow.GetVelocitiesAttr().Get(codes[2]), 2.0 * frame.fields["velocity"], rtol=1e-6)
    # Programs take a primvar called "velocity" for that of the film, and blur by it
    assert not UsdGeom.PrimvarsAPI(snow).HasPrimvar("velocity")
    field = UsdGeom.PrimvarsAPI(snow).GetPrimvar("run_velocity")
    np.testing.assert_array_equal(np.array(field.Get(codes[2])), frame.fields["velocity"])
    assert field.GetAttr().GetCustomDataByKey("units") == space.units["velocity"]
    mast = UsdGeom.Mesh(stage.GetPrimAtPath("/run/mast"))
    points = np.array(mast.GetPointsAttr().Get())
    place = np.array(UsdGeom.Xformable(mast).GetLocalTransformation(codes[2]))
    found = (np.column_stack([points, np.ones(len(points))]) @ place)[:, :3]
    wanted = space.obstacles["mast"].placed(2)
    assert cKDTree(found).query(wanted)[0].max() < 1e-3 and cKDTree(wanted).query(found)[0].max() < 1e-3


def test_usd_holds_what_stands_still_once(space, tmp_path):
    Usd = pytest.importorskip("pxr.Usd")

    path, picture = export_run(space, tmp_path, "usd", surface=True)
    stage = Usd.Stage.Open(str(path))
    for name in ("ground", "house", "mast"):
        prim = stage.GetPrimAtPath(f"/run/{name}")
        changing = [one.GetName() for one in prim.GetAttributes() if one.GetNumTimeSamples()]
        assert changing == (["xformOp:transform"] if name == "mast" else []), name
    assert picture.name == "ground.png" and Image.open(picture).size[0] <= 1024


def test_usd_has_normals_materials_camera_and_light(space, tmp_path):
    Usd = pytest.importorskip("pxr.Usd")
    from pxr import UsdGeom, UsdLux, UsdShade

    path, _ = export_run(space, tmp_path, "usd", surface=True, size=(800, 450))
    stage = Usd.Stage.Open(str(path))
    assert not faults(path)
    for name, material in (("snow", "snow"), ("ground", "ground"), ("house", "obstacle")):
        mesh = UsdGeom.Mesh(stage.GetPrimAtPath(f"/run/{name}"))
        bound = UsdShade.MaterialBindingAPI(mesh).ComputeBoundMaterial()[0]
        assert bound.GetPath() == f"/run/materials/{material}"
        shader = bound.ComputeSurfaceSource()[0]
        assert shader.GetIdAttr().Get() == "UsdPreviewSurface"
        code = next(iter(mesh.GetPointsAttr().GetTimeSamples()), Usd.TimeCode.Default())
        points, faces = np.array(mesh.GetPointsAttr().Get(code)), np.array(mesh.GetFaceVertexIndicesAttr().Get(code))
        normals = np.array(mesh.GetNormalsAttr().Get(code))
        assert len(normals) == len(points) and np.linalg.norm(normals, axis=1) == pytest.approx(1.0, abs=1e-5)
        corners = points[faces.reshape(-1, 3)].astype(float)
        flat = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        flat /= np.linalg.norm(flat, axis=1, keepdims=True)
        away = np.einsum("mi,mki->mk", flat, normals[faces.reshape(-1, 3)])
        # A house has sharp edges, snow and ground none
        assert away.min() > 0.999 if name == "house" else np.median(away) > 0.9
    # Fields of particles are no part of a mesh that is lit
    found = {one.GetPrimvarName() for one in UsdGeom.PrimvarsAPI(
        stage.GetPrimAtPath("/run/snow")).GetPrimvarsWithAuthoredValues()}
    assert found == {"displayColor"}
    view = view_of(space, (800, 450), "snow", drawn=False)
    camera = UsdGeom.Camera(stage.GetPrimAtPath("/run/camera")).GetCamera(Usd.TimeCode.Default())
    to_film = np.array(camera.frustum.ComputeViewMatrix() * camera.frustum.ComputeProjectionMatrix())
    points = view.action.points[:50].astype(float)
    clip = np.column_stack([points, np.ones(50)]) @ to_film
    x, y, _ = view.camera.project(points)
    assert 400.0 * (1.0 + clip[:, 0] / clip[:, 3]) == pytest.approx(x, abs=0.1)
    assert 225.0 * (1.0 - clip[:, 1] / clip[:, 3]) == pytest.approx(y, abs=0.1)
    sun = UsdLux.DistantLight(stage.GetPrimAtPath("/run/sun"))
    turn = np.array(UsdGeom.Xformable(sun).GetLocalTransformation())
    assert turn[2, :3] == pytest.approx(view.sun)  # it shines along its -z
    assert UsdLux.DomeLight(stage.GetPrimAtPath("/run/sky"))


def test_usd_has_the_moving_camera_of_the_film(space, section, tmp_path):
    Usd = pytest.importorskip("pxr.Usd")
    from pxr import UsdGeom

    path, _ = export_run(space, tmp_path, "usd", camera="follow", fps=10.0)
    stage = Usd.Stage.Open(str(path))
    camera = UsdGeom.Xformable(stage.GetPrimAtPath("/run/camera"))
    view = view_of(space, (1280, 720), "snow", "follow", drawn=False)
    for code in (0.0, 20.0, 80.0):
        eye = np.array(camera.GetLocalTransformation(code))[3, :3]
        assert eye == pytest.approx(view.path.camera(code / 10.0, (1280, 720)).eye, abs=1e-6)
    (path,) = export_run(section, tmp_path / "section", "usd")
    stage = Usd.Stage.Open(str(path))
    assert UsdGeom.Camera(stage.GetPrimAtPath("/run/camera")).GetProjectionAttr().Get() == "orthographic"


def faults(path):
    """What USD's own validators say of a file, by whichever of the two that the library has."""
    from pxr import Usd, UsdUtils

    try:
        from pxr import UsdValidation
    except ImportError:
        checker = UsdUtils.ComplianceChecker(arkit=False, skipARKitRootLayerCheck=False)
        checker.CheckCompliance(str(path))
        return [*checker.GetErrors(), *checker.GetFailedChecks()]
    validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    return [one.GetMessage() for one in UsdValidation.ValidationContext(validators).Validate(Usd.Stage.Open(str(path)))]


def at(points, time):
    """Points that move along x at 1 m/s."""
    return points + np.array([time, 0.0, 0.0])


@pytest.fixture(scope="module")
def shuffled(tmp_path_factory):
    """A run whose particles change their order with every frame; one of them leaves."""
    from snowmpm.io import RunWriter

    path, rng = tmp_path_factory.mktemp("shuffled"), np.random.default_rng(1)
    points = rng.random((50, 3))
    with RunWriter(path, provenance={"particle_spacing": 0.1}) as writer:
        for time in (0.0, 1.0, 2.0):
            order = rng.permutation(50 if time < 2.0 else 49).astype(np.int32)
            writer.frame(time, at(points[order], time), {"id": order, "density": 100.0 * points[order, 0]})
    return Run(path), points


def test_usd_points_keep_their_ids_and_order(shuffled, tmp_path):
    Usd = pytest.importorskip("pxr.Usd")
    from pxr import UsdGeom

    run, points = shuffled
    (path,) = export_run(run, tmp_path, "usd", fields=["density"])
    stage = Usd.Stage.Open(str(path))
    snow = UsdGeom.Points(stage.GetPrimAtPath("/run/snow"))
    assert str(snow.GetIdsAttr().GetTypeName()) == "int64[]"
    for code, time, count in zip(snow.GetIdsAttr().GetTimeSamples(), run.times, (50, 50, 49), strict=True):
        np.testing.assert_array_equal(snow.GetIdsAttr().Get(code), np.arange(count))
        np.testing.assert_allclose(snow.GetPointsAttr().Get(code), at(points[:count], time), rtol=1e-6)
    (path,) = export_run(run, tmp_path / "all", "usd")
    stage = Usd.Stage.Open(str(path))
    field = UsdGeom.PrimvarsAPI(stage.GetPrimAtPath("/run/snow")).GetPrimvar("id")
    assert str(field.GetTypeName()) == "int[]"


def test_usd_points_without_numbers_hold_until_the_next_sample(tmp_path):
    """A program that goes from one sample to the next point by point must not mix two particles."""
    Usd = pytest.importorskip("pxr.Usd")
    from pxr import UsdGeom

    from snowmpm.io import RunWriter

    points, rng = np.random.default_rng(2).random((40, 3)), np.random.default_rng(3)
    with RunWriter(tmp_path / "run", provenance={"particle_spacing": 0.1}) as writer:
        for time in (0.0, 1.0, 2.0):
            writer.frame(time, at(points[rng.permutation(40)], 0.01 * time), {"density": np.ones(40)})
    (path,) = export_run(Run(tmp_path / "run"), tmp_path / "out", "usd", fps=10.0)
    stage = Usd.Stage.Open(str(path))
    snow = UsdGeom.Points(stage.GetPrimAtPath("/run/snow")).GetPointsAttr()
    for code, time in ((3.3, 0.0), (9.9, 0.0), (15.0, 1.0), (20.0, 2.0)):
        found, wanted = (np.array(sorted(map(tuple, one))) for one in (snow.Get(code), at(points, 0.01 * time)))
        np.testing.assert_allclose(found, wanted, atol=1e-6)


@pytest.mark.parametrize("kind", ["ply", "gltf"])
def test_files_keep_one_order_of_the_particles(kind, shuffled, tmp_path):
    run, points = shuffled
    paths = [path for path in export_run(run, tmp_path, kind) if path.suffix in (".ply", ".glb")]
    for path, time, count in zip(paths, run.times, (50, 50, 49), strict=True):
        snow = trimesh.load(path, process=False)
        snow = snow.geometry["snow"] if kind == "gltf" else snow
        np.testing.assert_allclose(snow.vertices, at(points[:count], time), rtol=1e-6)
    if kind == "ply":
        numbers = snow.metadata["_ply_raw"]["vertex"]["data"]["id"]
        assert numbers.dtype == np.int32 and np.array_equal(np.ravel(numbers), np.arange(49))


def test_numbers_beyond_those_that_floats_hold(tmp_path):
    """Whole numbers are exact in every format, also where single precision skips some."""
    from snowmpm.render.export.gltf import _attributes
    from snowmpm.render.export.ply import write_ply
    from snowmpm.render.export.sequence import Shape

    numbers = np.array([5, (1 << 24) + 1, (1 << 40) + 1])
    (low, lows), (high, highs) = _attributes(numbers[:2].astype(np.int32))
    assert (low, high) == ("_LOW", "_HIGH")
    np.testing.assert_array_equal(np.float32(lows) + 65536 * np.float64(np.float32(highs)), numbers[:2])
    shape = Shape(np.zeros((3, 3), np.float32), None, {"id": numbers})
    found = trimesh.load(write_ply(tmp_path / "a.ply", shape, ""), process=False).metadata["_ply_raw"]["vertex"]
    np.testing.assert_array_equal(np.ravel(found["data"]["id"]), numbers)


def test_a_section_becomes_a_strip(section, tmp_path):
    export_run(section, tmp_path, "ply", fields=["damage"])
    ground = trimesh.load(tmp_path / "ground.ply", process=False)
    assert np.ptp(ground.vertices[:, 1]) > 0.0 and ground.area > np.ptp(ground.vertices[:, 0])
    snow = trimesh.load(tmp_path / "snow_0001.ply", process=False)
    same_points(snow.vertices, section.frame(1))
    assert set(snow.metadata["_ply_raw"]["vertex"]["properties"]) == {"x", "y", "z", "damage"}


def test_the_surface_is_closed_around_the_snow(tmp_path):
    """A block of particles: a mesh without holes, as large as the block."""
    from snowmpm.io import RunWriter

    spacing = 0.1
    axes = [np.arange(0.5 * spacing, size, spacing) for size in (2.0, 1.0, 0.5)]
    points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    with RunWriter(tmp_path / "run", provenance={"particle_spacing": spacing}, origin=ORIGIN) as writer:
        writer.frame(0.0, points, {"height": points[:, 2]})
    (path, _) = export_run(Run(tmp_path / "run"), tmp_path, "ply", surface=True)
    mesh = trimesh.load(path, process=True)
    assert mesh.is_watertight and mesh.volume == pytest.approx(1.0, rel=0.15)
    height = np.ravel(trimesh.load(path, process=False).metadata["_ply_raw"]["vertex"]["data"]["height"])
    assert height == pytest.approx(trimesh.load(path, process=False).vertices[:, 2], abs=1.5 * spacing)


def test_bad_wishes(space, tmp_path):
    for options, said in (({"kind": "obj"}, "--as"), ({"kind": "ply", "every": 0}, "--every"),
                          ({"kind": "ply", "speed": 0.0}, "--speed"),
                          ({"kind": "ply", "fields": ["speed"]}, "--fields")):
        with pytest.raises(InputError, match=said):
            export_run(space, tmp_path / "none", **options)
    assert not (tmp_path / "none").exists()


@pytest.mark.parametrize("words", [("export", "--as", "ply", "--camera", "top"), ("plot", "--color", "density"),
                                   ("plot", "--time", "1")])
def test_options_that_would_do_nothing_are_refused(space, tmp_path, words):
    command, *rest = words
    done = subprocess.run([sys.executable, "-m", "snowmpm", command, str(space.path), "-o", str(tmp_path / "out.png"),
                           *rest], capture_output=True, text=True)
    assert done.returncode == 2 and rest[-2] in done.stderr and not list(tmp_path.iterdir())
