"""Colours and pictures of mesh files: what is read, from where, into the run file, and onto pictures."""

import json
import shutil
import struct

import h5py
import numpy as np
import pytest
import trimesh
from PIL import Image

import snowmpm
from snowmpm.errors import InputError
from snowmpm.io import Run, RunWriter
from snowmpm.render.cinema.solids import Solid, edged
from snowmpm.render.export import export_run
from snowmpm.solids.skin import skins_of
from snowmpm.terrain.mesh import mesh_facets

WALL, ROOF = (200, 120, 60), (153, 26, 20)


@pytest.fixture
def house(tmp_path):
    """A cube of 2 m with a picture on one side and red on the others, as OBJ, MTL and PNG."""
    pixels = np.zeros((8, 8, 3), np.uint8)
    pixels[:4], pixels[4:] = WALL, (0, 0, 255)  # blue below
    Image.fromarray(pixels).save(tmp_path / "wall.png")
    box = trimesh.creation.box(extents=[2.0, 2.0, 2.0])
    front = np.flatnonzero(box.face_normals[:, 0] > 0.5)
    st = {(-1.0, -1.0): 1, (1.0, -1.0): 2, (1.0, 1.0): 3, (-1.0, 1.0): 4}
    lines = ["mtllib house.mtl", *(f"v {x} {y} {z}" for x, y, z in box.vertices), "vt 0 0", "vt 1 0", "vt 1 1",
             "vt 0 1", "usemtl wall"]
    lines += ["f " + " ".join(f"{v + 1}/{st[tuple(box.vertices[v, 1:])]}" for v in box.faces[k]) for k in front]
    lines += ["usemtl red", *("f " + " ".join(str(v + 1) for v in face) for k, face in enumerate(box.faces)
                              if k not in front)]
    (tmp_path / "house.obj").write_text("\n".join(lines) + "\n")
    (tmp_path / "house.mtl").write_text("newmtl wall\nKd 1 1 1\nmap_Kd wall.png\nnewmtl red\nKd 0.6 0.1 0.08\n")
    return tmp_path / "house.obj"


def wall_of(skins):
    return next(skin for skin in skins if skin.picture.shape[0] > 1)


def test_an_obj_file_has_its_materials_and_pictures(house):
    skins = skins_of(house)
    assert len(skins) == 2 and sum(len(skin.facets) for skin in skins) == 12
    wall = wall_of(skins)
    assert wall.picture.shape == (8, 8, 3) and len(wall.facets) == 2
    up = wall.vertices[:, 2] > 0.0
    np.testing.assert_array_equal(np.round(wall.colours(wall.st[up] * 0.5 + [0.25, 0.4])), [WALL] * up.sum())
    np.testing.assert_array_equal(np.round(wall.colours([[0.5, 0.2], [3.5, -0.8]])), [(0, 0, 255)] * 2)  # repeated
    np.testing.assert_array_equal(next(skin for skin in skins if skin is not wall).picture, [[ROOF]])


def test_glb_is_turned_upright_and_has_the_same_colours(house, tmp_path):
    scene = trimesh.load_scene(house)
    scene.apply_transform(trimesh.transformations.rotation_matrix(-0.5 * np.pi, [1.0, 0.0, 0.0]))
    scene.apply_transform(trimesh.transformations.translation_matrix([0.0, 5.0, 0.0]))  # 5 m up
    scene.export(tmp_path / "house.glb")
    vertices, facets = mesh_facets(tmp_path / "house.glb")
    assert len(facets) == 12
    np.testing.assert_allclose([vertices.min(axis=0), vertices.max(axis=0)], [[-1, -1, 4], [1, 1, 6]], atol=1e-6)
    wall = wall_of(skins_of(tmp_path / "house.glb"))
    np.testing.assert_allclose(wall.vertices[:, 0], 1.0, atol=1e-6)
    np.testing.assert_array_equal(np.round(wall.colours([[0.5, 0.8], [0.5, 0.2]])), [WALL, (0, 0, 255)])


def test_colours_of_vertices(tmp_path):
    box = trimesh.creation.box(extents=[1.0, 1.0, 1.0])
    box.visual.vertex_colors = np.tile([10, 200, 30, 255], (8, 1)).astype(np.uint8)
    box.export(tmp_path / "box.ply")
    (skin,) = skins_of(tmp_path / "box.ply")
    np.testing.assert_array_equal(np.round(skin.colours(skin.st)), [(10, 200, 30)] * 36)


def test_a_mesh_without_colours_has_none(tmp_path):
    trimesh.creation.box(extents=[1.0, 1.0, 1.0]).export(tmp_path / "box.stl")
    assert skins_of(tmp_path / "box.stl") == []


@pytest.mark.parametrize("name", ["../secret.png", "/etc/hostname", "a\\..\\..\\secret.png", "linked.png", "C:\\a.png"])
def test_no_picture_from_outside_the_folder_is_opened(house, name, tmp_path):
    inner = tmp_path / "inner"
    inner.mkdir()
    shutil.copy(house, inner)
    shutil.copy(tmp_path / "wall.png", tmp_path / "secret.png")
    (inner / "linked.png").symlink_to(tmp_path / "secret.png")
    (inner / "house.mtl").write_text(f"newmtl wall\nKd 1 1 1\nmap_Kd {name}\nnewmtl red\nKd 0.6 0.1 0.08\n")
    with pytest.warns(UserWarning, match="outside its folder"):
        skins = skins_of(inner / "house.obj")
    assert all(skin.picture.shape == (1, 1, 3) for skin in skins)


def test_what_is_missing_or_no_picture_is_told(house, tmp_path):
    (tmp_path / "wall.png").write_bytes(b"no picture")
    with pytest.warns(UserWarning, match=r"wall\.png is no picture"):
        assert all(skin.picture.size == 3 for skin in skins_of(house))
    (tmp_path / "house.mtl").unlink()
    with pytest.warns(UserWarning, match=r"house\.mtl is not there"):
        assert skins_of(house) == []


def test_a_picture_of_too_many_pixels_is_not_unpacked(house, tmp_path):
    Image.new("1", (9000, 9000)).save(tmp_path / "wall.png")
    with pytest.warns(UserWarning, match="makes 81 million pixels"):
        assert all(skin.picture.size == 3 for skin in skins_of(house))


def test_a_large_picture_is_kept_smaller(house, tmp_path):
    Image.new("RGB", (3000, 1500), WALL).save(tmp_path / "wall.png")
    assert wall_of(skins_of(house)).picture.shape == (1024, 2048, 3)


def glb(header, data=b""):
    text = json.dumps(header).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(data), 0x004E4942) + data
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


TABLE = {"componentType": 5126, "type": "VEC3", "count": 3}
PART = {"meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}], "asset": {"version": "2.0"}}


@pytest.mark.parametrize(("header", "words"), [
    ({**PART, "accessors": [{**TABLE, "count": 10**12}], "nodes": [{"mesh": 0}]}, "larger than the file"),
    ({**PART, "accessors": [{**TABLE, "count": 200}], "nodes": [{"mesh": 0}] * 500}, "larger than the file"),
    ({**PART, "accessors": [TABLE], "nodes": [{"children": [1]}, {"children": [0]}]}, "deep within each other"),
    ({**PART, "accessors": [TABLE], "nodes": [{"children": [1, 1]}, {"mesh": 0}]}, "two others hold"),
    ({**PART, "accessors": [TABLE], "extensionsRequired": ["KHR_draco_mesh_compression"]}, "KHR_draco"),
    ({**PART, "accessors": [{**TABLE, "count": -5}], "nodes": [{"mesh": 0}]}, "larger than the file"),
    ({"meshes": 3}, "not a readable GLB"), ([], "not a readable GLB")])
def test_a_harmful_glb_file_is_refused(header, words, tmp_path):
    (tmp_path / "a.glb").write_bytes(glb(header))
    with pytest.raises(InputError, match=words):
        mesh_facets(tmp_path / "a.glb")


@pytest.fixture
def run(house, tmp_path):
    skins = skins_of(house)
    vertices, facets = mesh_facets(house)
    rng = np.random.default_rng(0)
    ground = np.array([[-5.0, -5.0, -1.0], [5.0, -5.0, -1.0], [5.0, 5.0, -1.0], [-5.0, 5.0, -1.0]])
    path = tmp_path / "run"
    with RunWriter(path, provenance={"particle_spacing": 0.3}, terrain=(ground, np.array([[0, 1, 2], [0, 2, 3]])),
                   obstacles={"house": (vertices, facets)}, skins={"house": skins}) as writer:
        for time in (0.0, 1.0):
            writer.frame(time, rng.uniform(1.2, 2.5, (300, 3)) * [1.0, 1.0, 0.3], {"velocity": np.ones((300, 3))},
                         poses={"house": (np.eye(3), np.array([time, 0.0, 0.0]))})
    return path


def test_the_run_file_keeps_them(run, house):
    found = Run(run).obstacles["house"].skins
    for one, wanted in zip(found, skins_of(house), strict=True):
        for name in ("vertices", "facets", "picture"):
            np.testing.assert_array_equal(getattr(one, name), getattr(wanted, name))
        np.testing.assert_allclose(one.st, wanted.st, atol=1e-6)


@pytest.mark.parametrize("change", ["no_picture", "wide", "floats", "far", "not_finite", "table"])
def test_a_run_file_with_harmful_colours_is_refused(run, change):
    with h5py.File(run / "run.vtkhdf", "r+") as h5:
        skin = h5["obstacles/house/skin"]
        part = skin["0"]
        if change == "no_picture":
            del part["picture"]
        elif change in ("wide", "floats"):
            del part["picture"]
            part["picture"] = np.zeros((2, 5000, 3), np.uint8) if change == "wide" else np.zeros((2, 2, 3))
        elif change == "far":
            part["facets"][0, 0] = 10**6
        elif change == "not_finite":
            part["st"][0, 0] = np.nan
        else:
            del h5["obstacles/house/skin"]
            h5["obstacles/house/skin"] = np.zeros(3)
    with pytest.raises(InputError, match=r"run\.vtkhdf"):
        _ = Run(run).obstacles


def test_a_solid_has_the_colours_of_its_picture_where_they_are(house):
    solid = Solid.of(*(getattr(wall_of(skins_of(house)), name) for name in ("vertices", "facets")), 0.2,
                     wall_of(skins_of(house)))
    colours = wall_of(skins_of(house)).colours(solid.st)
    blue = colours[:, 2] > colours[:, 0]
    assert (solid.vertices[blue, 2] < 0.2).all() and (solid.vertices[~blue, 2] > -0.2).all()
    edge = solid.vertices[solid.faces]
    assert np.linalg.norm(edge - np.roll(edge, 1, axis=1), axis=2).max() <= 0.2


def test_sharp_edges_have_vertices_of_their_own_and_round_ones_do_not():
    box = trimesh.creation.box(extents=[1.0, 1.0, 1.0])
    assert len(edged(box.vertices, box.faces)[0]) == 24
    ball = trimesh.creation.icosphere(subdivisions=3)
    assert len(edged(ball.vertices, ball.faces)[0]) == len(ball.vertices)


def test_usd_has_them_as_materials(run, tmp_path):
    usd = pytest.importorskip("pxr.Usd")
    from pxr import UsdGeom, UsdShade

    paths = export_run(snowmpm.open_run(run), tmp_path / "out", "usd")
    stage = usd.Stage.Open(str(paths[0]))
    (wall,) = (k for k, skin in enumerate(snowmpm.open_run(run).obstacles["house"].skins) if skin.picture.size > 3)
    prim = stage.GetPrimAtPath(f"/run/house_{wall}")
    assert not stage.GetPrimAtPath("/run/house")
    material = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial()[0]
    reader = UsdShade.Shader(stage.GetPrimAtPath(f"{material.GetPath()}/picture"))
    picture = tmp_path / "out" / reader.GetInput("file").Get().path
    assert np.asarray(Image.open(picture)).shape == (8, 8, 3)
    assert len(UsdGeom.PrimvarsAPI(prim).GetPrimvar("st").Get()) == len(UsdGeom.Mesh(prim).GetPointsAttr().Get())
    times = UsdGeom.Xformable(prim).GetOrderedXformOps()[0].GetTimeSamples()
    assert len(times) == 2  # it moves, as the obstacle does


def test_a_scene_takes_them_from_its_mesh_and_stays_where_it_is(house, tmp_path):
    (tmp_path / "s.toml").write_text("""
name = "s"
dimension = 3
end_time = 0.02
[domain]
min = [-3.0, -3.0, -3.0]
max = [3.0, 3.0, 3.0]
[solver]
dx = 0.5
[materials.snow]
kind = "elastic"
density = 300.0
youngs_modulus = 1e6
poisson_ratio = 0.2
[[bodies]]
name = "snow"
material = "snow"
shape = { kind = "box", min = [1.5, -1.0, -1.0], max = [2.5, 1.0, 1.0] }
[[obstacles]]
name = "house"
shape = { kind = "mesh", file = "house.obj" }
""")
    run = snowmpm.run(snowmpm.load_scene(tmp_path / "s.toml"), tmp_path / "run")
    obstacle = run.obstacles["house"]
    corners = np.concatenate([skin.vertices for skin in obstacle.skins])
    np.testing.assert_allclose([corners.min(axis=0), corners.max(axis=0)],
                               [obstacle.vertices.min(axis=0), obstacle.vertices.max(axis=0)], atol=1e-9)


@pytest.mark.parametrize("axis", range(3))
@pytest.mark.parametrize("turned", [False, True])
def test_faces_with_an_inward_corner_become_triangles_within_them(axis, turned, tmp_path):
    """A gable with eaves."""
    outline = [(0.0, 0.0), (4.0, 0.0), (4.0, 2.0), (5.0, 2.0), (2.0, 5.0), (-1.0, 2.0), (0.0, 2.0)]
    front = np.insert(np.array(outline), axis, 0.0, axis=1)[:: -1 if turned else 1]
    back = front + 3.0 * np.eye(3)[axis]
    n = len(front)
    lines = [*(f"v {x} {y} {z}" for x, y, z in np.concatenate([front, back])),
             "f " + " ".join(str(k) for k in range(n, 0, -1)), "f " + " ".join(str(n + k) for k in range(1, n + 1)),
             *(f"f {k + 1} {(k + 1) % n + 1} {n + (k + 1) % n + 1} {n + k + 1}" for k in range(n))]
    (tmp_path / "a.obj").write_text("\n".join(lines) + "\n")
    vertices, facets = mesh_facets(tmp_path / "a.obj")
    corners = vertices[facets]
    areas = 0.5 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    ends = np.ptp(corners[:, :, axis], axis=1) == 0.0
    assert areas[ends].sum() == pytest.approx(2.0 * (4.0 * 2.0 + 0.5 * 6.0 * 3.0))  # no fold, no gap
    mesh = trimesh.Trimesh(vertices, facets)
    assert mesh.is_watertight and abs(mesh.volume) == pytest.approx(3.0 * 17.0)


def test_a_polygon_that_crosses_itself_ends(tmp_path):
    (tmp_path / "a.obj").write_text("v 0 0 0\nv 1 1 0\nv 1 0 0\nv 0 1 0\nv 2 2 0\nf 1 2 3 4 5\n")
    assert len(mesh_facets(tmp_path / "a.obj")[1]) == 3


def test_many_large_faces_are_not_cut_for_ever(tmp_path):
    rng = np.random.default_rng(0)
    lines = [f"v {x} {y} 0" for x, y in rng.random((200, 2))]
    lines += ["f " + " ".join(str(1 + k) for k in rng.permutation(200)) for _ in range(300)]
    (tmp_path / "a.obj").write_text("\n".join(lines) + "\n")
    assert len(mesh_facets(tmp_path / "a.obj")[1]) == 300 * 198  # fans, from where it would take too long


def test_links_in_circles_and_impossible_names_are_told(house, tmp_path):
    (tmp_path / "wall.png").unlink()
    (tmp_path / "wall.png").symlink_to(tmp_path / "wall.png")
    with pytest.warns(UserWarning, match=r"wall\.png (cannot be read|is not there)"):
        assert all(skin.picture.size == 3 for skin in skins_of(house))
    (tmp_path / "house.mtl").write_text(f"newmtl wall\nmap_Kd {'x' * 5000}\nnewmtl red\nKd 1 0 0\n")
    with pytest.warns(UserWarning, match="cannot be read"):
        skins_of(house)


def test_pictures_in_glb_files_are_looked_at_before_they_are_read(tmp_path):
    for name, words in (("large.png", "million pixels"), ("a.gif", "a picture that is none")):
        if name == "a.gif":
            Image.new("P", (8, 8)).save(tmp_path / name)
        else:
            Image.new("1", (9000, 9000)).save(tmp_path / name)
        data = (tmp_path / name).read_bytes()
        header = {**PART, "accessors": [TABLE], "images": [{"bufferView": 0, "mimeType": "image/png"}],
                  "bufferViews": [{"buffer": 0, "byteOffset": 0, "byteLength": len(data)}]}
        (tmp_path / "a.glb").write_bytes(glb(header, data))
        with pytest.warns(UserWarning, match=words):
            assert skins_of(tmp_path / "a.glb") == []
