"""Cameras that move: along a table, round the action, and with it."""

import copy

import numpy as np
import pytest
from synthetic_runs import slab_2d, slab_3d

from snowmpm.errors import InputError
from snowmpm.io import Run
from snowmpm.render import render_run
from snowmpm.render.camera_path import CameraPath, path_of
from snowmpm.render.space_view import SpaceView

SIZE, ORIGIN = (160, 90), np.array([5.0e5, 2.0e5, 1.5e3])
HEADER = "time [s],eye_x,eye_y,eye_z,target_x,target_y,target_z,field_of_view [deg]\n"


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    folder = tmp_path_factory.mktemp("run")
    slab_3d(folder, particles=3000, frames=9, origin=ORIGIN)
    return Run(folder)


@pytest.fixture(scope="module")
def still(run):
    """A view that does not move, without words."""
    view = SpaceView(run, SIZE, "snow", "auto")
    view.plain = True
    return view


def table(path, *rows):
    path.write_text(HEADER + "".join(",".join(f"{number:g}" for number in row) + "\n" for row in rows))
    return path


def seen(camera, points):
    """Share of the points within the picture."""
    x, y, depth = camera.project(points)
    return float(((x > 0) & (x < SIZE[0]) & (y > 0) & (y < SIZE[1]) & (depth > 0.0)).mean())


def test_a_path_goes_through_its_places_and_stays_at_its_ends(run, tmp_path):
    rows = ((1.0, 500100, 199900, 1700, 500050, 200000, 1480, 30.0),
            (3.0, 500200, 199900, 1650, 500080, 200000, 1470, 40.0),
            (4.0, 500200, 199950, 1600, 500080, 200000, 1460, 40.0))
    path = CameraPath.read(table(tmp_path / "path.csv", *rows), ORIGIN)
    for time, row in ((1.0, 0), (0.0, 0), (3.0, 1), (4.0, 2), (9.0, 2)):
        camera = path.camera(time, SIZE)
        assert camera.eye + ORIGIN == pytest.approx(rows[row][1:4])
        x, y, _ = camera.project(np.array([rows[row][4:7]]) - ORIGIN)
        assert (x[0], y[0]) == pytest.approx((80.0, 45.0), abs=0.05)
        half = camera.axes[2] + np.tan(np.radians(0.5 * rows[row][7])) * camera.axes[0]
        assert camera.project(camera.eye + 100.0 * half[None])[0][0] == pytest.approx(160.0, abs=0.1)
    between = path.camera(2.0, SIZE).eye + ORIGIN
    assert 500100.0 < between[0] < 500200.0 and between[1] == pytest.approx(199900.0)


def test_films_with_a_path_show_other_ground_in_each_frame(run, still, tmp_path):
    rows = ((0.0, 500060, 199800, 1600, 500060, 200000, 1470, 30.0),
            (8.0, 500260, 199900, 1600, 500060, 200000, 1470, 30.0))
    moving = copy.copy(still)
    moving.path, corner = CameraPath.read(table(tmp_path / "path.csv", *rows), ORIGIN), (slice(60, 90), slice(0, 40))
    change = [np.abs(np.diff([view.picture(i)[corner].astype(int) for i in (0, 8)], axis=0)).mean()
              for view in (moving, still)]
    assert change[0] > 5.0 * change[1]


def test_an_orbit_keeps_its_distance_and_the_action_in_sight(run, still):
    path = path_of("orbit", still.camera, run, still.action.points)
    ways = np.array([path.camera(time, SIZE).eye - path.targets[0] for time in run.times])
    away = np.linalg.norm(ways, axis=1)
    assert np.ptp(away) < 1e-3 * away[0]
    turned = np.degrees(np.subtract(*[np.arctan2(ways[k, 1], ways[k, 0]) for k in (-1, 0)])) % 360.0
    assert turned == pytest.approx(70.0, abs=0.5)
    assert min(seen(path.camera(time, SIZE), still.action.points) for time in run.times) > 0.95


def test_a_camera_that_follows_is_nearer_and_loses_no_snow_that_moves(run, still):
    path = path_of("follow", still.camera, run, still.action.points)
    for i, time in enumerate(run.times):
        points = run.frame(i, []).points
        low, high = np.quantile(points, [0.005, 0.995], axis=0)
        core = points[((points >= low) & (points <= high)).all(axis=1)]
        assert seen(path.camera(time, SIZE), core) > 0.98
    middle = path.camera(run.times[4], SIZE)
    assert still.action.size_in(middle) > 1.1 * still.action.size_in(still.camera)


@pytest.mark.parametrize(("rows", "told"), [
    (((1.0, 0, 0, 9, 0, 0, 0, 30.0), (1.0, 0, 0, 8, 0, 0, 0, 30.0)), "line 3: the time must rise"),
    (((0.0, 0, 0, 9, 0, 0, 0, 30.0), (1.0, 0, 0, 8, 0, 0, 8, 30.0)), "line 3: eye and target must be apart"),
    (((0.0, 0, 0, 9, 0, 0, 0, 300.0), (1.0, 0, 0, 8, 0, 0, 0, 30.0)), "line 2: field_of_view must be from 1 to 120"),
])
def test_a_path_that_cannot_be_is_refused(tmp_path, rows, told):
    with pytest.raises(InputError, match=told):
        CameraPath.read(table(tmp_path / "path.csv", *rows), np.zeros(3))


def test_paths_are_of_runs_in_three_dimensions_and_name_their_columns(run, tmp_path):
    short = tmp_path / "short.csv"
    short.write_text("time,eye_x,eye_y\n0,1,2\n1,2,3\n")
    with pytest.raises(InputError, match="has no column eye_z"):
        render_run(run, tmp_path / "a.png", camera_path=short)
    good = table(tmp_path / "path.csv", (0, 0, 0, 9, 0, 0, 0, 30), (1, 0, 0, 8, 0, 0, 0, 30))
    with pytest.raises(InputError, match='goes without camera = "top"'):
        render_run(run, tmp_path / "a.png", camera="top", camera_path=good)
    slab_2d(tmp_path / "flat", frames=1)
    with pytest.raises(InputError, match="three dimensions"):
        render_run(tmp_path / "flat", tmp_path / "a.png", camera_path=good)
