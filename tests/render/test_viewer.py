"""The interactive page: ground, snow, fields and maps in it, and what its scripts make of them, under Node.js."""

import io
import json
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
import trimesh
from page_content import checked, content
from PIL import Image
from scipy.spatial import cKDTree
from synthetic_runs import gully, height, slab_2d, slab_3d

import snowmpm.render.page
from snowmpm.io import Run
from snowmpm.render import render_page
from snowmpm.render.run_film import view_of
from snowmpm.render.surface_points import surface_points
from snowmpm.render.viewer import viewer
from snowmpm.render.viewer.ground import cut, fewer
from snowmpm.render.viewer.packing import Parts

NODE = shutil.which("node")
WEB = Path(snowmpm.render.page.__file__).parent / "web"


@pytest.fixture(scope="module")
def shown(tmp_path_factory):
    """(run, header, arrays, metres, text of its page) of a slab in space."""
    folder = tmp_path_factory.mktemp("shown")
    slab_3d(folder, particles=5000, frames=3, cell=5.0, origin=(1000.0, 2000.0, 50.0), obstacles=True)
    text = checked(render_page(folder, folder / "scene.html", camera="200,35"))
    return Run(folder), *content(text), text


def test_snow_of_every_frame_is_where_it_is(shown):
    run, head, parts, place, text = shown
    assert head["times"] == pytest.approx(run.times.tolist()) and head["origin"] == [1000.0, 2000.0, 50.0]
    assert len(text) < 2e6
    for k, (seen, every) in enumerate(head["frames"]):
        snow, points, normals = run.frame(k).points, parts[f"snow.{k}.place"], parts[f"snow.{k}.normal"]
        assert 100 < seen == len(normals) <= every == len(points)
        assert np.allclose(place(points).mean(axis=0), snow.mean(axis=0), atol=3.0)  # surface and all: not the same
        assert np.allclose(np.linalg.norm(normals / 127.0, axis=1), 1.0, atol=0.03)
    # What rests is at the low end of the scale of speed, what moves is not
    assert parts["snow.0.value.0"].mean() < 20 < parts["snow.1.value.0"].mean()
    assert len(parts["solid.facets"]) == 12 + 128


def test_ground_is_that_of_the_run_with_straight_edges(shown):
    run, head, parts, place, _ = shown
    facets = parts["ground.facets"][: head["ground"]["facets"]]
    ground = place(parts["ground.place"])[np.unique(facets)]
    true = trimesh.Trimesh(run.terrain.vertices, run.terrain.facets, process=False)
    _, off, _ = trimesh.proximity.closest_point(true, ground[:: max(1, len(ground) // 300)])
    assert off.max() < 2e-3 * head["reach"] / 100  # what 16 bits of the scene's extent resolve
    # Every edge that has one facet lies on the box of the ground
    edges = np.sort(np.concatenate([facets[:, [0, 1]], facets[:, [1, 2]], facets[:, [2, 0]]]), axis=1)
    single, count = np.unique(edges, axis=0, return_counts=True)
    x0, y0, x1, y1 = head["ground"]["box"]
    rim = place(parts["ground.place"])[single[count == 1]]
    step = 1e-4 * head["reach"]
    on = [np.abs(rim[..., axis] - at).max(axis=1) < step for axis, at in ((0, x0), (0, x1), (1, y0), (1, y1))]
    assert np.any(on, axis=0).all()
    picture = np.asarray(Image.open(io.BytesIO(bytes(parts["ground.picture"]))))
    assert max(picture.shape) == 900 and picture.std() > 5.0


def test_ground_of_a_turned_plane_is_cut_along_a_line():
    """Triangles that no axis follows: their rim lies on the box to rounding, and nothing within is lost."""
    turn = np.radians(31.0)
    vertices, facets = gully(5.0)
    vertices = vertices @ np.array([[np.cos(turn), -np.sin(turn), 0.0], [np.sin(turn), np.cos(turn), 0.0],
                                    [0.0, 0.0, 1.0]])
    middle = vertices[:, :2].mean(axis=0)
    lower, upper = middle - 30.0, middle + np.array([40.0, 25.0])
    new, triangles = cut(vertices, facets, lower, upper)
    corners = new[triangles][:, :, :2]
    side, other = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    area = 0.5 * np.abs(side[:, 0] * other[:, 1] - side[:, 1] * other[:, 0])
    assert area.sum() == pytest.approx(70.0 * 55.0, rel=1e-9)
    assert (new[:, :2] >= lower - 1e-9).all() and (new[:, :2] <= upper + 1e-9).all()


def test_fewer_triangles_on_the_same_vertices():
    vertices, facets = gully(2.0)
    new, triangles = fewer(vertices, facets, 2000)
    assert 1000 < len(triangles) <= 2400 < len(facets)
    far, _ = cKDTree(vertices).query(new)
    assert far.max() < 1e-3
    assert np.allclose(new[:, :2].min(axis=0), vertices[:, :2].min(axis=0))
    centres = new[triangles].mean(axis=1)
    assert np.abs(centres[:, 2] - height(centres[:, 0], centres[:, 1])).max() < 1.0
    assert fewer(vertices, facets, len(facets))[1] is facets


def test_fields_and_maps_to_choose_from(shown):
    run, head, parts, _, _ = shown
    assert [field["title"] for field in head["fields"]] == ["speed [m/s]", "density [kg/m3]"] and head["field"] == 0
    assert all(len(field["table"]) == 768 for field in head["fields"])
    density = head["fields"][1]
    shares = parts["snow.1.value.1"].ravel() / 255.0
    found = density["low"] + shares * (density["high"] - density["low"])
    true = run.frame(1).fields["density"]
    assert np.abs(found.mean() - true.mean()) < 5.0 and found.min() >= true.min() - 2.0
    layer, raster = head["layers"][0], run.maps["peak_depth"]
    values = parts["layer.0"].astype(float)
    assert layer["title"] == "peak flow depth [m]" and values.shape == (layer["rows"], layer["columns"])
    inside = raster.values[np.isfinite(raster.values)]
    assert (values > 0).sum() == len(inside)
    told = layer["low"] + (values[values > 0] - 1.0) / 254.0 * (layer["high"] - layer["low"])
    # But for the half per cent that the scale leaves out, in order of their cells
    whole = np.minimum(inside, layer["high"])
    assert np.abs(told - whole).max() < 0.51 * layer["high"] / 254.0
    first = np.isfinite(raster.values).any(axis=0).argmax()
    assert layer["x0"] == pytest.approx(raster.x0 + raster.cell * (first - 0.5))


def test_plain_snow_keeps_the_other_fields(tmp_path):
    slab_2d(tmp_path, frames=2)
    head = content(checked(render_page(tmp_path, tmp_path / "scene.html", color="snow")))[0]
    assert head["field"] == -1 and "speed [m/s]" in [field["title"] for field in head["fields"]]


def test_page_of_a_section(tmp_path):
    slab_2d(tmp_path, frames=3, obstacles=True)
    head, parts, place = content(checked(render_page(tmp_path, tmp_path / "scene.html")))
    assert len(head["frames"]) == 3 and head["camera"]["azimuth"] == pytest.approx(np.pi) and head["flat"]
    assert np.ptp(place(parts["snow.0.place"])[:, 1]) < 1e-3 * head["span"][0] and head["layers"] == []
    assert "ground.picture" not in parts


def test_what_lies_within_comes_after_the_surface():
    grid = np.stack(np.meshgrid(*[np.arange(0.05, 2.0, 0.1)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    values = np.column_stack([grid[:, 2], 1.0 - grid[:, 2]])
    found, surface = surface_points(grid, values, 0.2, within=True), surface_points(grid, values, 0.2)
    assert len(found.points) == 10**3 and len(found.normals) == len(surface.points) < 600
    assert np.array_equal(found.points[: len(surface.points)], surface.points)
    within = found.points[len(surface.points):]
    assert (within[:, :2] > 0.2).all() and (within[:, :2] < 1.8).all() and (within[:, 2] < 1.8).all()
    assert np.allclose(found.values[:, 0], found.points[:, 2], atol=1e-5)


def test_a_page_becomes_as_small_as_asked(shown):
    run, head = shown[:2]
    text = viewer(run, view_of(run, (320, 180), drawn=False), letters=30_000)
    small, parts, _ = content(text)
    assert sum(every for _, every in small["frames"]) < 0.5 * sum(every for _, every in head["frames"])
    ground = 4 / 3 * sum(parts[name].nbytes for name in parts if name.startswith("ground"))
    assert len(text) < 1.5 * 30_000 + ground


@pytest.mark.parametrize("kind", ["u1", "i1", "u2", "u4"])
def test_packing_keeps_every_number(kind):
    rng = np.random.default_rng(4)
    info = np.iinfo(kind)
    values = rng.integers(info.min, info.max, (50, 3), endpoint=True).astype(kind)
    values[0] = info.max
    parts = Parts()
    parts.add("a", values)
    parts.add_bytes("b", b"raw")
    parts.add("c", np.zeros((0, 3), kind))
    head = json.dumps({"parts": parts.table, "low": 0, "span": 1})
    text = f'<script type="application/json">{head}</script><script class="data">{parts.text()}</script>'
    found = content(text)[1]
    assert np.array_equal(found["a"], values) and bytes(found["b"]) == b"raw" and found["c"].shape == (0, 3)


def in_node(code, given, folder):
    """What the last line `answer = ...` of a script gives, after those of the page that need no browser."""
    if NODE is None:
        pytest.skip("needs Node.js")
    scripts = "\n".join((WEB / name).read_text(encoding="utf-8") for name in ("unpack.js", "stance.js", "pick.js",
                                                                              "measure.js"))
    file = folder / "page_scripts.js"
    file.write_text(f"{scripts}\nconst given = {json.dumps(given)};\n(async () => {{ let answer;\n{code}\n"
                    "process.stdout.write(JSON.stringify(answer)); })();\n", encoding="utf-8")
    done = subprocess.run([NODE, str(file)], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


READ = "const head = given.head, data = unpack(head.parts, await inflated(given.data));\n"


@pytest.fixture(scope="module")
def given(shown):
    """Header and data of the page as its scripts find them."""
    text = shown[-1]
    return {"head": shown[1], "data": text.split('class="data">')[1].split("</script>")[0]}


def test_scripts_read_what_was_packed(shown, given, tmp_path):
    sums = in_node(READ + "answer = Object.fromEntries(Object.entries(data).map(([name, v]) =>"
                   " [name, [v.length, v.reduce((a, b) => a + b, 0)]]));", given, tmp_path)
    assert sums == {name: [values.size, int(values.astype(np.int64).sum())] for name, values in shown[2].items()}


@pytest.mark.parametrize("size", [(1280, 640), (390, 700)], ids=["desk", "phone"])
def test_first_view_holds_the_action_and_a_ray_leads_back(given, size, tmp_path):
    code = READ + """const stance = new Stance(head.camera, () => given.size, head.reach); stance.fit(head.keep);
        const seen = head.keep.map(p => stance.project(p)), back = head.keep.map((p, i) => {
            const {from, along} = stance.ray(...seen[i]), d = p.map((v, k) => v - from[k]), t = dot(d, along);
            return Math.hypot(...d.map((v, k) => v - t * along[k])); });
        answer = {seen, back, eye: stance.eye(), matrix: [...stance.matrix()]};"""
    found = in_node(code, {**given, "size": size}, tmp_path)
    seen = np.array(found["seen"]) / size
    assert (seen > 0.055).all() and (seen < 0.945).all()
    assert max(np.abs(seen - 0.5).max(axis=0)) > 0.43  # and no farther than that
    assert max(found["back"]) < 1e-6 * given["head"]["reach"]
    # The matrix of the shaders puts them where the page does
    keep = np.column_stack([given["head"]["keep"], np.ones(len(seen))])
    clip = keep @ np.reshape(found["matrix"], (4, 4))
    assert np.allclose(0.5 + 0.5 * clip[:, 0] / clip[:, 3], seen[:, 0], atol=1e-4)
    assert np.allclose(0.5 - 0.5 * clip[:, 1] / clip[:, 3], seen[:, 1], atol=1e-4)


def test_a_ray_meets_the_ground_where_trimesh_says(shown, given, tmp_path):
    run = shown[0]
    spots = [[30.0, 20.0], [90.0, -30.0], [150.0, 5.0], [500.0, 0.0]]
    code = READ + """const m = new Measure(head, data, null, null, null);
        const down = ([x, y]) => ({from: [x, y, 500], along: [0, 0, -1]});
        answer = given.spots.map(p => meetsFacets(down(p), m.ground, data["ground.facets"], () => true));"""
    found = in_node(code, {**given, "spots": spots}, tmp_path)
    true = trimesh.Trimesh(run.terrain.vertices, run.terrain.facets, process=False)
    for (x, y), t in zip(spots[:-1], found[:-1], strict=True):
        hits, _, _ = true.ray.intersects_location([[x, y, 500.0]], [[0.0, 0.0, -1.0]])
        assert 500.0 - t == pytest.approx(hits[:, 2].max(), abs=0.02)
    assert found[-1] is None  # beyond the ground


def test_measure_tells_place_value_length_and_respects_the_cut(shown, given, tmp_path):
    code = READ + """const stance = new Stance(head.camera, () => [1000, 600], head.reach); stance.fit(head.keep);
        const m = new Measure(head, data, stance, {}, {}), shown = {frame: 0, field: 0, layer: 0, cut: null};
        const at = given.places.map(p => stance.project(p));
        m.tap(...at[0], shown); m.tap(...at[1], shown); m.draw();
        const cut = {...shown, cut: [1, 0, 0, 50]};
        answer = {places: m.places, words: m.words, marks: m.marks.innerHTML, sky: m.probe(500, 0, shown),
                  cut: m.probe(...at[1], cut)};"""
    places = [[110.0, 30.0, float(height(110.0, 30.0))], [150.0, -20.0, float(height(150.0, -20.0))]]
    found = in_node(code, {**given, "places": places}, tmp_path)
    assert np.allclose(found["places"], places, atol=0.5)
    p, q = np.array(found["places"])
    length, rise = np.linalg.norm(q - p), q[2] - p[2]
    slope = np.degrees(np.arctan2(rise, np.hypot(*(q - p)[:2])))
    assert f"{length:.1f} m, " in found["words"][1] and f"slope {slope:.1f}°" in found["words"][1]
    assert "bearing 141°" in found["words"][1]
    x, y, _ = q + np.array([1000.0, 2000.0, 50.0])
    assert found["words"][0].startswith(f"{x:.1f}, {y:.1f}, ") and "peak flow depth [m]: " in found["words"][0]
    assert found["marks"].count("<circle") == 2 and found["sky"] is None
    assert found["cut"] is None or found["cut"]["place"][0] <= 50.001
