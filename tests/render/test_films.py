"""Films and pictures of made-up runs: is the snow where it should be, in the right colour, in the right number?"""

import subprocess
import sys

import imageio.v2 as imageio
import numpy as np
import pytest
from scipy import ndimage
from synthetic_runs import slab_2d, slab_3d

from snowmpm.errors import InputError
from snowmpm.io import Run, RunWriter
from snowmpm.render import light, render_run
from snowmpm.render.colour import choose_scale
from snowmpm.render.section_view import SectionView
from snowmpm.render.snow import draw_snow
from snowmpm.render.solid import AREA, draw_solids, placed, rings
from snowmpm.render.space_view import SpaceView
from snowmpm.render.view import particle_spacing

SIZE = (320, 180)


@pytest.fixture(scope="module")
def space(tmp_path_factory):
    folder = tmp_path_factory.mktemp("space")
    slab_3d(folder, particles=30000, frames=5)
    return Run(folder)


@pytest.fixture(scope="module")
def section(tmp_path_factory):
    folder = tmp_path_factory.mktemp("section")
    slab_2d(folder, frames=5)
    return Run(folder)


@pytest.fixture(scope="module")
def plain_view(space):
    return SpaceView(space, SIZE, "snow", "auto")


@pytest.fixture(scope="module")
def density_view(space):
    return SpaceView(space, SIZE, "density", "auto")


@pytest.fixture(scope="module")
def speed_view(space):
    return SpaceView(space, SIZE, None, "auto")


def near_centre(view, i):
    """Boolean picture: pixels close to where the middle of the snow of frame `i` must appear."""
    points = view.run.frame(i, []).points
    middle = np.median(points, axis=0)
    core = points[np.linalg.norm(points - middle, axis=1) < 4.0]
    x, y, _ = view.camera.project(core)
    found = np.zeros(SIZE[::-1], bool)
    found[y.astype(int), x.astype(int)] = True
    return found


def whiteness(picture):
    return picture.min(axis=-1).astype(float)


def test_snow_is_white_where_the_particles_are_and_nowhere_else(plain_view):
    first, last = plain_view.picture(0), plain_view.picture(4)
    for here, there, now, other in ((0, 4, first, last), (4, 0, last, first)):
        snow = near_centre(plain_view, here)
        snow[:40] = False  # the heading
        assert snow.sum() > 20
        assert np.median(whiteness(now)[snow]) > 190  # of 255: snow
        assert np.median(whiteness(other)[snow & ~near_centre(plain_view, there)]) < 150  # bare ground


def test_snow_hides_behind_the_terrain(space):
    """From behind the slope, whose open surface is seen from below there, nothing of it may shine through."""
    view = SpaceView(space, SIZE, "snow", "270,-20")
    assert (view.ground.slack < 0.0).mean() > 0.2
    ground = light.encode(view.ground.light)
    changed = np.abs(view.picture(4)[45:150].astype(int) - ground[45:150]).max(axis=-1) > 40
    assert changed.sum() <= 3  # px: where the coarse triangles cut below the smooth slope


def test_fast_snow_takes_the_colour_of_its_speed_and_resting_snow_is_white(speed_view):
    def redness(i):
        snow = near_centre(speed_view, i)
        picture = speed_view.picture(i).astype(float)
        return np.median((picture[..., 0] - picture[..., 2])[snow])

    assert redness(0) < 20 and redness(4) < 20
    assert redness(2) > 35


def test_colour_follows_the_field(plain_view, density_view):
    snow = near_centre(plain_view, 2)
    difference = np.abs(plain_view.picture(2).astype(int) - density_view.picture(2))[snow].max(axis=-1)
    assert np.median(difference) > 60


def test_colour_scale_is_drawn_with_the_colours_of_the_map(plain_view, density_view):
    wanted = 255.0 * density_view.scale.table()[::16]

    def found(view):
        corner = view.picture(0)[120:].reshape(-1, 1, 3).astype(float)  # where nothing but the scale has colour
        return np.mean(np.abs(corner - wanted).max(axis=-1).min(axis=0) < 4.0)

    assert found(density_view) > 0.9  # the strip of a small picture has fewer pixels than the map colours
    assert found(plain_view) < 0.3


def test_automatic_camera_shows_the_snow_of_every_frame(space, plain_view):
    for i in range(len(space)):
        points = space.frame(i, []).points
        x, y, depth = plain_view.camera.project(points)
        inside = (x > 0) & (x < SIZE[0]) & (y > 0) & (y < SIZE[1])
        assert inside.mean() > 0.995  # strays may leave the picture
        column, row = x[inside].astype(int), y[inside].astype(int)
        in_front = depth[inside] < plain_view.ground.depth[row, column] + 3.0
        assert in_front.mean() > 0.9


@pytest.mark.parametrize("camera", ["top", "side", "front", "200,35"])
def test_named_cameras_show_the_snow(space, camera):
    view = SpaceView(space, SIZE, "snow", camera)
    x, y, _ = view.camera.project(space.frame(2, []).points)
    assert np.mean((x > 0) & (x < SIZE[0]) & (y > 0) & (y < SIZE[1])) > 0.99
    change = np.abs(view.picture(2).astype(int) - light.encode(view.ground.light))[45:140]
    assert (change.max(axis=-1) > 40).sum() > 100


def test_map_coordinates_change_nothing_and_a_hole_shows_the_sky(tmp_path):
    pictures = []
    for name, options in (("a", {}), ("b", {"origin": (5.0e5, 2.0e5, 1.5e3)}), ("c", {"hole": True})):
        slab_3d(tmp_path / name, particles=5000, frames=2, **options)
        render_run(tmp_path / name, tmp_path / f"{name}.png", camera="top", size=SIZE)
        pictures.append(imageio.imread(tmp_path / f"{name}.png").astype(int))
    assert np.array_equal(pictures[0], pictures[1])
    changed = np.abs(pictures[0] - pictures[2]).max(axis=-1) > 30
    assert 0.005 < changed.mean() < 0.2


def test_obstacles_of_a_section_are_where_their_pose_says_and_under_snow_and_ground(tmp_path):
    slab_2d(tmp_path, frames=5, obstacles=True)
    run = Run(tmp_path)
    view = SectionView(run, (640, 360), None, "side")
    for i in (0, 2, 4):
        picture, camera = view.picture(i).astype(int), view.track.camera(i)
        corners = run.obstacles["wheel"].placed(i)
        middle = corners.mean(axis=0)
        inner = np.concatenate([middle + share * (corners - middle) for share in (0.2, 0.6)])
        column, row = (np.round(values).astype(int) for values in camera.project(inner)[:2])
        is_solid = np.abs(picture - light.encode(AREA).astype(int)).max(axis=-1) <= 2
        assert is_solid[row, column].mean() > 0.9
        x, y, _ = camera.project(corners)
        box = is_solid[:, int(x.min()) - 3 : int(x.max()) + 4]
        rows = np.flatnonzero(box.any(axis=1))
        assert abs(rows[0] - y.min()) < 5.0 and rows[-1] < y.max() + 1.0
        foot = run.obstacles["wall"].placed(i)[:2].mean(axis=0) + np.array([0.0, 0.0, 0.5])
        column, row, _ = (int(value[0]) for value in camera.project(foot[None]))
        assert not is_solid[row, column]  # in the ground
    assert abs(run.obstacles["wheel"].placed(4)[:, 0].mean() - run.obstacles["wheel"].placed(0)[:, 0].mean()) > 3.0


def test_obstacles_in_space_are_seen_before_what_is_behind_them_only(tmp_path):
    slab_3d(tmp_path, particles=30000, frames=5, obstacles=True)
    run = Run(tmp_path)
    view = SpaceView(run, SIZE, "snow", "auto")
    for i in (0, 2, 4):
        vertices, facets = placed(run, i)
        solids = draw_solids(view.ground, view.camera, view.sun, vertices, facets)
        changed = solids.slack == 0.0
        x, y, depth = view.camera.project(vertices)
        column, row = x.astype(int), y.astype(int)
        assert (solids.depth[changed] < view.ground.depth[changed]).all() and changed.sum() > 60
        rows, columns = np.nonzero(changed)
        assert (x.min() - 1 <= columns.min()) and (columns.max() <= x.max() + 1) and (y.min() - 1 <= rows.min())
        up = vertices[:, 2] > run.obstacles["house"].placed(i)[:, 2].mean()
        seen = np.abs(solids.depth[row, column] - depth) < 1.5
        assert seen[up].mean() > 0.3 and np.array_equal(solids.light[~changed], view.ground.light[~changed])
    behind = np.median(vertices, axis=0) + 40.0 * view.camera.axes[2]
    cloud = behind + np.random.default_rng(0).normal(0.0, 3.0, (4000, 3))
    front = draw_snow(solids, view.camera, view.sun, cloud - 80.0 * view.camera.axes[2], 0.5)
    hidden = draw_snow(solids, view.camera, view.sun, cloud, 0.5)
    assert np.abs(front - solids.light)[changed].max() > 0.1
    inside = ndimage.binary_erosion(changed, iterations=2)
    assert inside.any() and np.abs(hidden - solids.light)[inside].max() < 1e-6


def test_a_chain_of_segments_becomes_rings():
    facets = np.array([[4, 5], [0, 1], [2, 0], [5, 6], [1, 2], [6, 4]])
    assert [sorted(ring) for ring in rings(facets)] == [[4, 5, 6], [0, 1, 2]]
    assert next(rings(facets)) == [4, 5, 6]


@pytest.mark.parametrize(("name", "fps"), [("film.mp4", 10), ("film.gif", 5)])
def test_film_has_every_frame_at_the_asked_rate(section, tmp_path, name, fps):
    calls = []
    path = render_run(section, tmp_path / "new" / name, size=SIZE, fps=fps, progress=lambda *c: calls.append(c))
    assert path == tmp_path / "new" / name
    assert calls == [(i, 5) for i in range(6)]
    with imageio.get_reader(path) as film:
        pictures = [film.get_data(i) for i in range(5)]
        if name.endswith("mp4"):
            assert film.count_frames() == 5
            assert film.get_meta_data()["duration"] == pytest.approx(5 / fps, abs=0.51 / fps)  # container rounding
        else:
            assert film.get_length() == 5
            assert film.get_meta_data()["duration"] == pytest.approx(1000 / fps)
    assert all(picture.shape[:2] == SIZE[::-1] for picture in pictures)
    assert np.abs(pictures[0][..., :3].astype(int) - pictures[2][..., :3]).max() > 60
    assert [entry.name for entry in path.parent.iterdir()] == [name]


def test_folder_gets_every_frame_and_png_the_one_asked_for(section, tmp_path):
    render_run(section, tmp_path / "pictures", size=SIZE, plain=True)  # without the pace of a film
    names = sorted(path.name for path in (tmp_path / "pictures").iterdir())
    assert names == [f"frame_{i:05d}.png" for i in range(5)]
    for time, frame in ((None, 4), (3.9, 2), (0.0, 0)):
        render_run(section, tmp_path / "one.png", time=time, size=SIZE, plain=True)
        one, expected = (imageio.imread(tmp_path / path) for path in ("one.png", f"pictures/{names[frame]}"))
        assert one.shape == (*SIZE[::-1], 3) and np.array_equal(one, expected)


def test_section_has_ground_below_its_profile_and_snow_on_it(section):
    view = SectionView(section, (640, 360), "snow", "side")
    assert not view.track.close
    points = section.frame(0, []).points
    x, y, _ = view.track.camera(0).project(points)
    picture = view.picture(0).astype(int)
    column, row = x.astype(int), y.astype(int)
    assert np.median(picture[row, column].min(axis=-1)) > 170
    assert np.median(picture[row + 12, column].max(axis=-1)) < 140  # ground
    assert np.median((picture[..., 2] - picture[..., 0])[row - 12, column]) > 5  # blue sky


def test_thin_snow_on_a_long_slope_gets_a_close_view_that_follows_it(section):
    view = SectionView(section, (640, 360), None, "auto")
    assert view.track.close
    for i in range(len(section)):
        frame = section.frame(i)
        x, y, _ = view.track.camera(i).project(frame.points)
        assert np.mean((x > 0) & (x < 640) & (y > 0) & (y < 360)) > 0.25
    thickness = 0.6 * view.track.scale
    assert thickness > 10.0  # px: what the close view is for
    assert view.track.centres[-1, 0] - view.track.centres[0, 0] > 40.0
    inset = view.picture(0)[10:110, 430:620].astype(int)
    red = (inset[..., 0] - inset[..., 2] > 100).sum()
    assert red > 50  # the frame that marks the view in the overview


def test_thick_snow_is_shown_whole(tmp_path):
    slab_2d(tmp_path, thickness=5.0, spacing=0.4, frames=3)
    view = SectionView(Run(tmp_path), (640, 360), None, "auto")
    assert not view.track.close
    assert np.ptp(view.track.centres, axis=0).max() == 0.0


def test_frames_without_particles_and_strays_are_drawn(tmp_path):
    for dimension in (2, 3):
        path = tmp_path / str(dimension)
        with RunWriter(path, provenance={}, dimension=dimension) as writer:
            for t, n in enumerate((50, 0, 1)):
                x = np.random.default_rng(t).random((n, dimension))
                x[:1] *= np.nan if n > 1 else 1.0
                writer.frame(float(t), x, {"velocity": np.zeros_like(x)})
        render_run(path, path / "film", size=(96, 64))
        assert len(list((path / "film").iterdir())) == 3


@pytest.mark.parametrize("dimension", [2, 3])
def test_order_of_the_particles_in_the_file_is_not_seen(tmp_path, dimension):
    """A solver sorts its particles as it goes: a film must not flicker with that."""
    rng = np.random.default_rng(0)
    points, identity = rng.random((3000, dimension)) * 2.0, np.arange(3000)
    with RunWriter(tmp_path, provenance={"particle_spacing": 0.05}, dimension=dimension) as writer:
        for _ in range(2):
            order = rng.permutation(3000)
            writer.frame(0.0, points[order], {"id": identity[order], "density": points[order, 0]})
    first, second = (
        (SectionView if dimension == 2 else SpaceView)(Run(tmp_path), SIZE, "density", "auto").picture(i).astype(int)
        for i in range(2)
    )
    assert np.ptp(first.reshape(-1, 3), axis=0).min() > 100
    assert np.mean(np.abs(first - second).max(axis=-1) > 8) < 0.002  # px where two balls are equally near


def test_spacing_comes_from_the_volume_or_else_from_neighbours(section, tmp_path):
    assert particle_spacing(section) == pytest.approx(0.12)
    grid = np.stack(np.meshgrid(*[np.arange(8) * 0.25] * 3), axis=-1).reshape(-1, 3)
    with RunWriter(tmp_path, provenance={}) as writer:
        writer.frame(0.0, grid, {})
    assert particle_spacing(Run(tmp_path)) == pytest.approx(0.25)


def test_scale_limits_hold_the_field_and_start_at_zero_for_speed(section):
    speed, density = choose_scale(section, None), choose_scale(section, "density")
    fastest = max(np.linalg.norm(section.frame(i).fields["velocity"], axis=1).max() for i in range(5))
    assert speed.field == "velocity" and speed.label == "speed" and speed.units == "m/s"
    assert speed.low == 0.0 and 0.98 * fastest < speed.high < 1.2 * fastest
    assert 0.0 < density.low < density.high == pytest.approx(250.0, rel=0.02)
    assert speed.table()[0].min() > 0.95  # what rests looks like snow
    lightness = speed.table() @ [0.21, 0.72, 0.07]
    assert (np.diff(lightness) < 0.0).all()


@pytest.mark.parametrize(
    ("options", "key"),
    [
        ({"color": "spede"}, "color"),
        ({"camera": "below"}, "camera"),
        ({"camera": "10,95"}, "camera"),
        ({"output": "film.avi"}, "output"),
        ({"size": (20, 180)}, "size"),
        ({"size": "big"}, "size"),
        ({"time": 1.0}, "time"),
        ({"fps": 0}, "fps"),
    ],
)
def test_bad_wishes_are_refused_in_one_line_with_nothing_written(space, tmp_path, options, key):
    settings = {"output": "film.mp4", "size": SIZE, **options}
    with pytest.raises(InputError, match=f"{key} = ") as caught:
        render_run(space, tmp_path / settings.pop("output"), **settings)
    assert "\n" not in str(caught.value) and list(tmp_path.iterdir()) == []


def test_run_without_frames_is_refused(tmp_path):
    RunWriter(tmp_path, provenance={}).close()
    with pytest.raises(InputError, match="no frame with particles"):
        render_run(tmp_path, tmp_path / "film.mp4")
    with pytest.raises(InputError, match="no run file"):
        render_run(tmp_path / "absent", tmp_path / "film.mp4")


def test_rendering_needs_no_taichi_no_solver_and_no_graphics_library(section, tmp_path):
    code = f"""
import sys
from snowmpm.render import render_run
render_run({str(section.path)!r}, {str(tmp_path / "one.png")!r}, size=(96, 64))
print([name for name in ("taichi", "vtkmodules", "pyvista", "snowmpm.mpm", "snowmpm.materials") if name in sys.modules])
"""
    output = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert output.strip() == "[]"
