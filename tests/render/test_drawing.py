"""The parts of the renderer against what geometry says: triangles, balls, discs, cameras, relief."""

import numpy as np
import pytest

from snowmpm.io import Terrain
from snowmpm.render.camera import fit_camera, view_axes
from snowmpm.render.colour import SNOW_WHITE_LOW, ColourScale
from snowmpm.render.framing import Action, choose_camera
from snowmpm.render.ground import contour_interval, draw_ground
from snowmpm.render.light import sun_direction
from snowmpm.render.overlay import Overlay, bands, ticks
from snowmpm.render.raster import rasterise
from snowmpm.render.relief import build_relief, plane_around
from snowmpm.render.section import draw_section, section_camera
from snowmpm.render.solid import AREA, RIM, draw_areas
from snowmpm.render.splat import splat_balls, splat_discs

SQUARE = np.array([[0, 1, 2], [0, 2, 3]])


def plane(slope, size=100.0):
    """A tilted plane of two large triangles, falling towards +x."""
    x = np.array([-size, size, size, -size])
    y = np.array([-size, -size, size, size])
    return Terrain(np.column_stack([x, y, -slope * x]), SQUARE)


def test_two_triangles_cover_a_rectangle_without_gap():
    x, y = np.array([2.0, 12.0, 12.0, 2.0]), np.array([3.0, 3.0, 9.0, 9.0])
    raster = rasterise(x, y, np.ones(4), SQUARE, (20, 16))
    expected = np.zeros((16, 20), bool)
    expected[3:9, 2:12] = True
    assert np.array_equal(raster.hit, expected)
    assert set(raster.facet[expected]) == {0, 1}
    rows, columns = np.nonzero(expected)
    # The weights reproduce the pixel centres; float32 weights of coordinates of order ten.
    assert np.allclose(
        raster.interpolate(np.column_stack([x, y]), SQUARE), np.column_stack([columns, rows]) + 0.5, atol=1e-5
    )


def test_the_nearer_triangle_is_seen_whatever_the_order():
    x, y = np.array([0.0, 10.0, 0.0] * 2), np.array([0.0, 0.0, 10.0] * 2)
    near = np.array([1.0, 1.0, 1.0, 2.0, 2.0, 2.0])
    for facets, nearest in (([[0, 1, 2], [3, 4, 5]], 1), ([[3, 4, 5], [0, 1, 2]], 0)):
        raster = rasterise(x, y, near, np.array(facets), (10, 10))
        assert raster.hit.sum() > 40 and (raster.facet[raster.hit] == nearest).all()


def test_perspective_depth_is_that_of_the_plane():
    """A floor seen obliquely: depth from the raster against depth of the ray's cut with the floor."""
    corners = np.array([[-40.0, -40.0, 0.0], [40.0, -40.0, 0.0], [40.0, 40.0, 0.0], [-40.0, 40.0, 0.0]])
    camera = fit_camera(corners, np.pi, np.radians(25.0), (120, 80))
    x, y, depth = camera.project(corners)
    raster = rasterise(x, y, 1.0 / depth, SQUARE, camera.size, perspective=True)
    seen = raster.interpolate(depth, SQUARE)
    rows, columns = np.nonzero(raster.hit)
    ray = camera.local(columns + 0.5, rows + 0.5, np.ones(len(rows))) @ camera.axes
    exact = -camera.eye[2] / ray[:, 2]
    assert len(seen) > 2000
    assert np.allclose(seen, exact, rtol=2e-5)  # float32 weights and depths


@pytest.mark.parametrize("perspective", [True, False])
def test_projection_and_its_inverse_agree(perspective):
    points = np.random.default_rng(0).normal([400.0, 200.0, 1500.0], 30.0, (50, 3))
    camera = fit_camera(points, 1.0, 0.5, (640, 360), perspective=perspective)
    x, y, depth = camera.project(points)
    back = camera.eye + camera.local(x, y, depth) @ camera.axes
    assert np.allclose(back, points, atol=5e-3)  # float32 over a few hundred metres


def test_fitted_camera_fills_the_free_part_of_the_picture():
    points = np.random.default_rng(1).normal(0.0, 1.0, (500, 3)) * [80.0, 20.0, 5.0]
    size, margins = (800, 450), (0.1, 0.1, 0.2, 0.1)
    camera = fit_camera(points, 0.4, 0.6, size, margins=margins)
    x, y, _ = camera.project(points)
    low, high = np.array([80.0, 90.0]), np.array([720.0, 405.0])
    tight = np.array([[x.min(), y.min()] - low, high - [x.max(), y.max()]])
    assert (tight > -1.0).all()  # px: the fit iterates
    assert (tight < 3.0).all(axis=0).any()


def test_camera_stands_at_its_bearing_with_north_up_from_above():
    right, up, forward = view_axes(np.radians(90.0), np.radians(30.0))
    assert np.allclose(-forward, [np.cos(np.pi / 6), 0.0, 0.5])  # out towards the east, 30 degrees up
    assert np.allclose(right, [0.0, 1.0, 0.0]) and up[2] > 0.0
    right, up, _ = view_axes(np.pi, 0.5 * np.pi)
    assert np.allclose(right, [1.0, 0.0, 0.0]) and np.allclose(up, [0.0, 1.0, 0.0])


def test_the_nearest_ball_is_seen_and_bulges_towards_the_camera():
    for order in (1, -1):
        x, y = np.array([20.5, 24.5])[::order], np.array([15.5, 15.5])
        number, _ = splat_balls(x, y, np.array([10.0, 12.0])[::order], 1.0, np.array([6.0, 6.0]), (50, 30))
        assert (number[15, 20:25] == (0 if order == 1 else 1)).all()
        number, _ = splat_balls(x[::-1], y, np.array([10.0, 12.0])[::order], 1.0, np.array([6.0, 6.0]), (50, 30))
        assert (number[15, 20:25] == (0 if order == 1 else 1)).all()
    x = np.array([20.5, 24.5])
    number, front = splat_balls(x, y, np.array([10.0, 12.0]), 1.0, np.array([6.0, 6.0]), (50, 30))
    assert number[15, 20] == 0 and number[15, 24] == 0 and number[15, 29] == 1
    assert front[15, 20] == pytest.approx(9.0) and front[15, 24] > 9.2
    assert np.isinf(front[0, 0]) and number[0, 0] == -1


def test_balls_at_the_border_do_not_wrap_around():
    number, _ = splat_balls(np.array([0.5, 49.5]), np.array([10.5, 20.5]), np.ones(2), 1.0, np.full(2, 5.0), (50, 30))
    assert (number[:, 10:40] == -1).all()
    assert (number[:, :10] == 0).any() and not (number[:, :10] == 1).any()


@pytest.mark.parametrize("radius", [1.3, 3.0, 7.7])
def test_a_disc_covers_its_area_wherever_it_lies(radius):
    for shift in (0.0, 0.21, 0.5):
        _, cover = splat_discs(np.array([30.0 + shift]), np.array([25.0 - shift]), radius, (60, 50))
        assert cover.sum() == pytest.approx(np.pi * radius**2, rel=0.11 / radius)  # a ramp at the rim, sampled


def test_relief_knows_heights_and_holes_and_faces_up():
    terrain = plane(0.5)
    flipped = Terrain(terrain.vertices, terrain.facets[:, ::-1])
    relief = build_relief(flipped, np.array([-20.0, -10.0]), np.array([30.0, 10.0]))
    ground = np.unique(relief.facets[: relief.ground])
    assert np.allclose(relief.normals[ground], np.array([0.5, 0.0, 1.0]) / np.hypot(0.5, 1.0))
    x, y = np.random.default_rng(0).uniform([[-19.0], [-9.0]], [[29.0], [9.0]], (2, 100))
    assert np.allclose(relief.height(x, y), -0.5 * x, atol=1e-4)  # a plane is linear; float32 weights
    assert np.isneginf(relief.height([60.0], [0.0])[0])
    half = build_relief(Terrain(terrain.vertices, terrain.facets[:1]), np.array([-20.0, -20.0]), np.array([20.0, 20.0]))
    assert np.isneginf(half.height([-10.0], [10.0])[0]) and np.isfinite(half.height([10.0], [-10.0])[0])


def test_a_plane_is_as_open_at_its_rim_as_within():
    """Otherwise the top of a slope is drawn too bright and its foot too dark. Also with a hole in it."""
    for slope in (0.0, 0.8):
        ground = plane(slope, size=40.0)
        relief = build_relief(ground, np.full(2, -60.0), np.full(2, 60.0))
        assert 0.3 < np.isfinite(relief.heights).mean() < 0.6  # with a rim all around
        assert np.abs(relief.openness - 1.0).max() < 1e-4
        heights = relief.heights.copy()
        heights[170:190, 150:200] = np.nan
        fitted = plane_around(heights, 6.0)
        assert np.nanmax(np.abs(fitted - heights)) < 1e-3 and (np.isfinite(fitted) == np.isfinite(heights)).all()


def test_gullies_see_less_sky_than_ridges():
    x, y = np.meshgrid(np.arange(-40.0, 40.5, 1.0), np.arange(-40.0, 40.5, 1.0))
    n = np.arange(x.size).reshape(x.shape)
    facets = np.concatenate([np.stack([n[:-1, :-1], n[:-1, 1:], n[1:, 1:]], -1).reshape(-1, 3),
                             np.stack([n[:-1, :-1], n[1:, 1:], n[1:, :-1]], -1).reshape(-1, 3)])
    vertices = np.column_stack([x.ravel(), y.ravel(), 3.0 * np.cos(x.ravel() * np.pi / 20.0)])
    relief = build_relief(Terrain(vertices, facets), np.full(2, -60.0), np.full(2, 60.0))
    ridge, gully = (float(relief.sample(relief.openness, [at], [0.0], 1.0)[0]) for at in (0.0, 20.0))
    assert gully < 0.85 and ridge > 1.05


def test_walls_stand_below_the_rim_and_face_outward():
    relief = build_relief(plane(0.5, 20.0), np.array([-30.0, -30.0]), np.array([30.0, 30.0]))
    corners = relief.vertices[relief.facets]
    rim = np.unique(relief.facets[relief.ground :])
    assert np.allclose(relief.normals[rim, 2], 0.0)
    middle = relief.vertices[:, :2].mean(axis=0)
    outward = ((relief.vertices[rim, :2] - middle) * relief.normals[rim, :2]).sum(axis=1)
    assert (outward > 0.0).all()
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    faces = (cross * relief.normals[relief.facets[:, 0]]).sum(axis=1)
    assert (faces > 0.0).all()  # walls and ground are seen from their lit side
    height = relief.vertices[rim, 2] + 0.5 * relief.vertices[rim, 0]
    assert np.allclose(np.unique(np.round(height, 6)), [-0.04 * np.ptp(relief.vertices[:, :2], axis=0).max(), 0.0])


def ridge(side):
    """Flat ground with a ridge of 20 m along y, at x = 10 m on the given side (1 or -1)."""
    x, y = np.meshgrid(np.linspace(-50, 50, 81), np.linspace(-50, 50, 81), indexing="ij")
    z = 20.0 * np.exp(-(((side * x - 10.0) / 5.0) ** 2))
    n = np.arange(81 * 81).reshape(81, 81)
    a, b, c, d = (k.ravel() for k in (n[:-1, :-1], n[1:, :-1], n[1:, 1:], n[:-1, 1:]))
    facets = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    return Terrain(np.stack([k.ravel() for k in (x, y, z)], 1), facets)


@pytest.mark.parametrize("side", [1, -1])
def test_automatic_camera_avoids_the_ridge(side):
    relief = build_relief(ridge(side), np.full(2, -50.0), np.full(2, 50.0))
    points = np.random.default_rng(0).uniform([-3.0, -30.0, 0.0], [3.0, 30.0, 1.0], (2000, 3)) - [6.0 * side, 0.0, 0.0]
    camera = choose_camera("auto", Action(points, np.array([0.0, 1.0])), relief, (320, 180))
    assert relief.visible(points, camera.eye, clearance=0.5).mean() > 0.9
    assert np.sign(camera.eye[0]) == -side


def test_of_views_about_as_good_the_larger_is_taken():
    """A slab that goes 30 m down a slope of 35 degrees: from 75 degrees beside its way it is as visible as from 52, and
    18 % larger. Its picture takes 0.47 of the width for 0.39; the bound was chosen after these figures."""
    rng, slope = np.random.default_rng(0), 0.7
    x, y = rng.uniform(-15.0, 15.0, 4000), rng.uniform(-7.0, 7.0, 4000)
    action = Action(np.column_stack([x, y, rng.uniform(0.0, 1.0, 4000) - slope * x]), np.array([1.0, 0.0]))
    ground = plane(slope, size=30.0)
    camera = choose_camera("auto", action, build_relief(ground, *action.box()), (1280, 720))
    assert np.ptp(camera.project(action.points)[0]) > 0.43 * 1280


def test_a_ridge_hides_what_is_behind_it():
    terrain = ridge(1)
    relief = build_relief(terrain, np.full(2, -50.0), np.full(2, 50.0))
    point = np.array([[-10.0, 0.0, 0.0]])
    assert not relief.visible(point, np.array([100.0, 0.0, 30.0]), clearance=0.5)[0]
    assert relief.visible(point, np.array([-100.0, 0.0, 30.0]), clearance=0.5)[0]
    assert relief.visible(point, np.array([60.0, 0.0, 150.0]), clearance=0.5)[0]
    shade = relief.sample(relief.sunlight(np.array([0.9, 0.0, 0.3])), np.array([-10.0, 30.0]), np.zeros(2), 1.0)
    assert shade[0] < 0.3 and shade[1] > 0.7


def test_ground_of_two_huge_triangles_is_drawn_up_to_the_camera():
    terrain = plane(0.3, size=5000.0)
    terrain = Terrain(terrain.vertices, terrain.facets[:, [0, 2, 1]])  # turned down: drawn all the same
    lower, upper = np.array([-60.0, -60.0]), np.array([60.0, 60.0])
    relief = build_relief(terrain, lower, upper)
    action = np.array([[-10.0, -5.0, 3.0], [10.0, 5.0, -3.0]])
    camera = fit_camera(action, np.radians(140.0), np.radians(30.0), (160, 90))
    ground = draw_ground(relief, camera, sun_direction(camera.axes, np.array([0.0, 0.0, 1.0])))
    assert np.isfinite(ground.depth).mean() > 0.8
    assert (ground.slack == 1.0).all()
    assert np.isfinite(ground.light).all() and ground.contour_interval > 0.0


def test_a_level_floor_has_no_contours_but_a_scale():
    """Round-off in the heights of a floor once made contours every micrometre."""
    assert contour_interval(1e-6 * np.random.default_rng(0).random((40, 40)), 0.4) == 0.0
    assert contour_interval(np.array([[0.0, np.nan], [30.0, 12.0]]), 50.0) == 2.0


@pytest.mark.parametrize("reach", [25.0, 400.0])
def test_the_rim_of_ground_that_is_little_larger_than_the_action_is_in_sight(reach):
    relief = build_relief(plane(0.5, reach), np.full(2, -reach), np.full(2, reach))
    points = np.random.default_rng(0).uniform([-20.0, -18.0], [20.0, 18.0], (500, 2))
    points = np.column_stack([points, -0.5 * points[:, 0]])
    size = (640, 360)
    camera = choose_camera("auto", Action(points, np.array([1.0, 0.0])), relief, size)
    inside = [((x > 0) & (x < size[0]) & (y > 0) & (y < size[1])).mean()
              for x, y, _ in (camera.project(relief.vertices), camera.project(points))]
    assert inside[1] == 1.0
    assert (inside[0] == 1.0) == (reach < 100.0)


def test_ground_that_is_seen_edge_on():
    """A plane that falls by 45 degrees towards +x: straight on, along it, from behind; the camera does not choose to
    look along it."""
    relief = build_relief(plane(1.0, 50.0), np.full(2, -50.0), np.full(2, 50.0))
    points = np.array([[3.0, 2.0, -3.0]])
    for way, expected in (([1.0, 0.0, 1.0], 1.0), ([-1.0, 0.0, 1.0], 0.0), ([-1.0, 0.0, 0.0], -np.sqrt(0.5))):
        assert relief.facing(points, points[0] + 1e3 * np.array(way)) == pytest.approx(expected, abs=1e-3)
    across = np.random.default_rng(0).uniform([-20.0, -18.0], [20.0, 18.0], (500, 2))
    action = Action(np.column_stack([across, -across[:, 0]]), np.array([-1.0, 0.0]))  # as if it went up
    camera = choose_camera("auto", action, relief, (640, 360))
    assert np.median(relief.facing(action.points, camera.eye)) > 0.3


@pytest.mark.parametrize(("stretch", "whole"), [(1.0, True), (1.5, True), (2.2, True), (4.0, False)])
def test_a_section_that_is_drawn_out_stays_whole(stretch, whole):
    """Particles up to 2.2 spacings apart, as in a shear band, show no sky between them; a gap of 4 is a crack. The
    outline of the body stays where it was."""
    x, z = (g.ravel() for g in np.meshgrid(np.arange(20.0) * stretch, np.arange(12.0), indexing="ij"))
    points = np.column_stack([x, np.zeros(len(x)), z])
    camera = section_camera(np.array([x.mean(), z.mean()]), 9.0, (900, 160))
    sky, black = draw_section(None, camera, np.zeros((0, 3)), 1.0), np.zeros((len(points), 3))
    covered = (draw_section(None, camera, points, 1.0, black) < 0.4 * sky).all(axis=-1)
    (left, right), (low, high) = ((int(at.min()), int(at.max())) for at in camera.project(points)[:2])
    inside = covered[low : high + 1, left : right + 1]
    assert inside.all() if whole else 0.2 < inside.mean() < 0.8
    rows, columns = np.nonzero(covered)
    beyond = [low - rows.min(), rows.max() - high, left - columns.min(), columns.max() - right]
    assert np.abs(np.array(beyond) - 0.8 * 9.0).max() <= 2.0



@pytest.mark.parametrize("apart", [0.0, 0.3])
def test_blocks_that_touch_are_told_apart(apart):
    """Two squares of a wall, one on the other: a dark joint between them, as at the rim of the whole; each is plain."""
    square = np.array([[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [4.0, 0.0, 4.0], [0.0, 0.0, 4.0]])
    vertices = np.concatenate([square, square + np.array([0.0, 0.0, 4.0 + apart])])
    ring = np.column_stack([np.arange(4), np.roll(np.arange(4), -1)])
    picture = np.ones((120, 80, 3), np.float32)
    camera = section_camera([2.0, 4.0], 10.0, (80, 120))
    draw_areas(picture, camera, vertices, np.concatenate([ring, ring + 4]))
    at = [camera.project(np.array([[2.0, 0.0, z]])) for z in (2.0, 6.0 + apart, 4.0 + 0.5 * apart, 3.9, 4.1 + apart)]
    lower, upper, joint, *beside = (picture[int(y[0]), int(x[0])] for x, y, _ in at)
    assert np.allclose(lower, AREA) and np.allclose(upper, AREA)
    assert all(np.allclose(rim, RIM * AREA, atol=1e-3) for rim in beside)
    assert np.allclose(joint, RIM * AREA, atol=1e-3) if apart == 0.0 else joint.mean() > AREA.mean()


def test_small_discs_of_a_section_close():
    """Particles less than two pixels apart: inside the body no sky shines through, wherever they lie on the pixels."""
    spacing, scale = 0.1, 17.3
    x, z = np.meshgrid(spacing * np.arange(60), spacing * np.arange(40))
    points = np.column_stack([x.ravel(), np.zeros(x.size), z.ravel()])
    camera = section_camera([2.95, 1.95], scale, (160, 120))
    picture = draw_section(None, camera, points, spacing)
    inner = picture[40:80, 50:110]
    assert np.ptp(inner.reshape(-1, 3), axis=0).max() < 0.02


@pytest.mark.parametrize("size", [(1280, 720), (1280, 200), (640, 480), (480, 480)])
def test_words_stay_in_the_bands_that_are_kept_free(size):
    """Heading above, colours and length scale side by side below: between the bands nothing is written."""
    blank = np.full((size[1], size[0], 3), 90, np.uint8)
    overlay = Overlay(blank)
    overlay.heading("elastic beam", 0.5)
    overlay.colour_scale(ColourScale("velocity", "speed", "m/s", 0.0, 1.0, SNOW_WHITE_LOW), "right")
    colours = (overlay.picture() != blank).any(axis=-1)
    overlay.length_scale(100.0, "right", beside=True)
    written = (overlay.picture() != blank).any(axis=-1)
    top, bottom = (share * size[1] for share in bands(size))
    assert not written[int(top) + 1 : int(size[1] - bottom) - 1].any()
    added = np.flatnonzero((written & ~colours).any(axis=0))
    assert added.size > 20 and added.min() > 0
    assert added.max() < np.flatnonzero(colours[size[1] // 2 :].any(axis=0)).min()


@pytest.mark.parametrize(("low", "high"), [(0.0, 32.0), (0.0, 0.05), (-4.0e4, 4.0e4), (180.0, 300.0)])
def test_ticks_are_few_and_round(low, high):
    found = ticks(low, high)
    assert 3 <= len(found) <= 8
    assert min(found) >= low and max(found) <= high * (1 + 1e-9)
    steps = np.diff(found)
    assert np.allclose(steps, steps[0]) and f"{steps[0]:.6e}"[0] in "125"
