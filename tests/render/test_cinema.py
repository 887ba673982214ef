"""The cinematic look: what the camera of PyVista sees, blur, light, and the ground to the horizon."""

import numpy as np
import pytest
import synthetic_runs
from scipy.spatial import cKDTree

from snowmpm.errors import InputError
from snowmpm.io import Run
from snowmpm.render import render_run
from snowmpm.render.camera import Camera, look_at
from snowmpm.render.cinema.body import clods, snow_body
from snowmpm.render.cinema.shade import through
from snowmpm.render.cinema.studio import Lens, Part, Studio
from snowmpm.render.cinema.view import CinemaView
from snowmpm.render.run_film import view_of

SIZE = (240, 136)


@pytest.fixture(scope="module")
def studio():
    made = Studio()
    try:
        seen(made, look_at(np.array([0.0, -10.0, 0.0]), np.zeros(3), 0.5, SIZE), np.zeros(3))
    except InputError as error:
        pytest.skip(str(error))
    return made


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    path = tmp_path_factory.mktemp("space")
    synthetic_runs.slab_3d(path, particles=4000, frames=4, obstacles=True, far=30.0)
    return Run(path)


def seen(studio, camera, place, lens=None, velocity=None, size=0.2):
    """Light (height, width) of a small white square at a place, which faces along y, before black."""
    corners = place + size * np.array([[-1, 0, -1], [1, 0, -1], [1, 0, 1], [-1, 0, 1]])
    part = Part(corners.astype(np.float32), np.array([[0, 1, 2], [0, 2, 3]]), np.ones((4, 3), np.float32),
                None if velocity is None else np.tile(np.float32(velocity), (4, 1)))
    lens = lens or Lens(focus=float((place - camera.eye) @ camera.axes[2]))
    return studio.shoot({}, [part], camera, lens, np.zeros((SIZE[1], SIZE[0], 3), np.float32))[..., 0]


def middle(picture):
    rows, columns = np.indices(picture.shape)
    return np.array([(columns + 0.5) * picture, (rows + 0.5) * picture]).sum(axis=(1, 2)) / picture.sum()


def test_things_are_where_the_camera_sees_them(studio):
    perspective = look_at(np.array([3.0, -10.0, 4.0]), np.array([0.0, 0.0, 1.0]), 0.6, SIZE)
    parallel = Camera(np.array([0.0, -10.0, 0.0]), look_at(np.array([0.0, -10.0, 0.0]), np.zeros(3), 0.5, SIZE).axes,
                      30.0, SIZE, perspective=False)
    for camera in (perspective, parallel):
        for place in (np.zeros(3), np.array([1.2, 0.5, 1.0]), np.array([-1.5, 0.0, -0.8])):
            picture = seen(studio, camera, place)
            x, y, _ = camera.project(place[None])
            assert middle(picture) == pytest.approx([x[0], y[0]], abs=0.6)


def test_what_moves_is_blurred_by_its_way_while_the_shutter_is_open(studio):
    camera = Camera(np.array([0.0, -10.0, 0.0]), look_at(np.array([0.0, -10.0, 0.0]), np.zeros(3), 0.5, SIZE).axes,
                    30.0, SIZE, perspective=False)
    sharp, blurred = (seen(studio, camera, np.zeros(3), Lens(16, 0.1, focus=10.0), velocity)
                      for velocity in ([0.0, 0.0, 0.0], [20.0, 0.0, 0.0]))
    widths = [np.ptp(np.flatnonzero((picture > 0.01).any(axis=0))) for picture in (sharp, blurred)]
    # 2 m in 0.1 s, at 30 pixels a metre; the ends of 16 shots lie a sixteenth apart
    assert widths[1] - widths[0] == pytest.approx(60.0 * 15 / 16, abs=2.0)
    assert blurred.sum() == pytest.approx(sharp.sum(), rel=0.02)


def test_what_is_out_of_focus_is_soft(studio):
    camera = look_at(np.array([0.0, -10.0, 0.0]), np.zeros(3), 0.5, SIZE)
    lens = Lens(32, radius=0.3, focus=10.0)
    sharp, soft = (seen(studio, camera, np.array([0.0, y, 0.0]), lens) for y in (0.0, 8.0))
    assert ((sharp > 0.05) & (sharp < 0.95)).sum() < 0.35 * (sharp > 0.05).sum()
    assert ((soft > 0.02) & (soft < 0.95)).sum() > 0.8 * (soft > 0.02).sum()


def test_light_in_snow_keeps_its_amount():
    """On a sphere, whose vertices have about the same number of neighbours; blue goes farther than red."""
    import trimesh

    ball = trimesh.creation.icosphere(subdivisions=4)
    lit = np.tile((ball.vertices[:, 2:] > 0.0).astype(np.float32), (1, 3))
    spread = through(lit, ball.faces)
    assert spread.mean(axis=0) == pytest.approx(lit.mean(axis=0), rel=0.02)
    beyond = (ball.vertices[:, 2] < 0.0) & (ball.vertices[:, 2] > -0.15)
    red, _, blue = spread[beyond].mean(axis=0)
    assert 0.0 < red < blue
    assert through(np.ones((len(lit), 3), np.float32), ball.faces) == pytest.approx(1.0)


def test_clods_stay_with_their_particles():
    points = np.random.default_rng(0).random((50, 3)).astype(np.float32)
    identity, rest = np.arange(50), np.zeros((50, 3), np.float32)
    first = clods(points, rest, 0.1, identity, 20.0)
    moved = clods(points + np.float32([1.0, 0.0, 0.0]), rest, 0.1, identity, 20.0)
    assert moved.vertices - first.vertices == pytest.approx(np.tile([1.0, 0.0, 0.0], (len(first.vertices), 1)),
                                                            abs=1e-5)
    assert np.array_equal(first.faces, moved.faces) and first.faces.max() < len(first.vertices)
    # and look the same where others are gone
    fewer = clods(points[::2], rest[::2], 0.1, identity[::2], 20.0)
    assert len(fewer.vertices) == len(first.vertices) // 2
    assert cKDTree(first.vertices).query(fewer.vertices)[0].max() < 1e-6
    assert not len(snow_body(points, rest, 0.1, loose=np.ones(50, bool)).vertices)


def test_the_ground_is_the_terrain_and_goes_on_without_a_step(run):
    view = view_of(run, SIZE, look="cinematic")
    land = view.landscape
    x, y, z = land.vertices.T.astype(float)
    known = view.relief.height(x, y)
    inside = known > -np.inf
    near_edge = 0.2 * np.ptp(view.terrain.vertices[:, 1])
    low, high = view.terrain.vertices[:, :2].min(axis=0), view.terrain.vertices[:, :2].max(axis=0)
    within = inside & (x > low[0] + near_edge) & (x < high[0] - near_edge) & (y > low[1] + near_edge) & (
        y < high[1] - near_edge)
    assert np.abs(z - known)[within].max() < 1e-3 and within.sum() > 1000
    grid = z.reshape(land.shape)
    lines = x.reshape(land.shape)[0], y.reshape(land.shape)[:, 0]
    for axis, line in ((1, lines[0]), (0, lines[1])):
        steps = np.abs(np.diff(grid, axis=axis)) / np.diff(line).reshape((1, -1) if axis == 1 else (-1, 1))
        assert steps.max() < 3.0  # no cliff where the terrain ends
    assert np.isfinite(land.covered).all() and land.covered.min() >= 0.0 and land.covered.max() <= 1.0
    extent = view.relief.cell * max(view.relief.heights.shape)
    assert max(np.ptp(lines[0]), np.ptp(lines[1])) > 10.0 * extent


def test_a_picture_of_a_run(studio, run, tmp_path):
    """Twice the same; with sky or haze above, snow that is bright, no words; other frames are other pictures."""
    view = view_of(run, SIZE, look="cinematic", quality="preview")
    assert isinstance(view, CinemaView)
    view.plain = True
    first, again, later = view.picture(1), view.picture(1), view.picture(3)
    assert first.shape == (SIZE[1], SIZE[0], 3) and np.array_equal(first, again)
    assert np.abs(first.astype(int) - later).max() > 60
    assert np.mean(first) > 100 and np.std(first) > 5
    full = view_of(run, SIZE, look="cinematic", camera="top")
    full.plain = True
    assert np.std(full.picture(2)) > 5
    render_run(run, tmp_path / "film.mp4", look="cinematic", quality="preview", size=SIZE, camera="follow")
    assert (tmp_path / "film.mp4").stat().st_size > 1000


def test_a_depth_averaged_flow_and_colours(studio, tmp_path):
    synthetic_runs.slab_3d(tmp_path, particles=2000, frames=3)
    view = view_of(Run(tmp_path), SIZE, color="speed", look="cinematic", quality="preview")
    view.plain = True
    picture = view.picture(1).astype(int)
    assert (picture[..., 0] - picture[..., 2]).max() > 60  # warm where it is fast


def test_what_goes_with_diagrams_only(run, tmp_path):
    section = tmp_path / "section"
    synthetic_runs.slab_2d(section, spacing=0.4, frames=2)
    for of, options, said in ((section, {}, "three dimensions"), (run, {"cutaway": True}, "cutaway"),
                              (run, {"layer": "depth"}, "pass")):
        output = tmp_path / ("a.tif" if "layer" in options else "a.png")
        with pytest.raises(InputError, match=said):
            render_run(of, output, look="cinematic", **options)
    with pytest.raises(InputError, match="look"):
        render_run(run, tmp_path / "a.png", look="noir")
    assert not list(tmp_path.glob("a.*"))
