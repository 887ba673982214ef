"""The map in a corner: it comes where the terrain is large, is right in plan, and hides nothing that moves."""

import itertools

import numpy as np
import pytest
from synthetic_runs import slab_3d

import snowmpm
from snowmpm.errors import InputError
from snowmpm.io import Run
from snowmpm.render import plan_inset, render_run
from snowmpm.render.camera import look_at
from snowmpm.render.framing import downhill
from snowmpm.render.overlay import EDGE, unit_of
from snowmpm.render.plan_inset import AREA, HIDDEN, PlanInset
from snowmpm.render.plan_map import VIEW
from snowmpm.render.run_film import view_of
from snowmpm.render.space_view import SpaceView
from snowmpm.scenes import load_scene

SIZE = (480, 270)
STRAYS = 0.005
"""Share of the snow ahead of its front, as the front of a run is defined."""


@pytest.fixture(scope="module")
def large(tmp_path_factory):
    """On terrain of 1 km, the avalanche going 100 m."""
    folder = tmp_path_factory.mktemp("large")
    slab_3d(folder, particles=4000, frames=7, cell=10.0, far=400.0, origin=(6e5, 2e5, 1500.0))
    return Run(folder)


@pytest.fixture(scope="module")
def small(tmp_path_factory):
    folder = tmp_path_factory.mktemp("small")
    slab_3d(folder, particles=2000, frames=5)
    return Run(folder)


@pytest.fixture(scope="module")
def view(large):
    return view_of(large, SIZE)


def seen_from(camera, run, size=SIZE, inset="auto"):
    """A view whose ground is not drawn, which takes most of the time."""
    return SpaceView(run, size, "snow", camera, drawn=False, inset=inset)


def box_of(inset):
    """(left, top, right, bottom) [px]."""
    rows, columns = inset.plan.heights.shape
    left, top = inset.position
    return left, top, left + columns, top + rows


def test_it_comes_by_itself_where_the_camera_shows_a_small_part(view, small):
    assert view.inset is not None
    assert seen_from("auto", small).inset is None
    assert seen_from("auto", small, inset="on").inset is not None


def test_it_is_in_the_picture_and_nothing_else_changes(view, large, monkeypatch):
    with_map, (left, top, right, bottom) = view.picture(4).astype(int), box_of(view.inset)
    monkeypatch.setattr(view, "inset", None)
    without = view.picture(4).astype(int)
    changed = np.abs(with_map - without).max(axis=2) > 0
    rows, columns = np.nonzero(changed)
    assert rows.min() >= top - 1 and rows.max() <= bottom + 1
    assert columns.min() >= left - 1 and columns.max() <= right + 1
    assert changed[top:bottom, left:right].mean() > 0.9


def test_its_front_is_that_of_the_run(view, large):
    """In each frame: no nearer than the front, with the strays ahead of it, by more than a cell, and no farther than
    the farthest particle by more than one."""
    plan = view.inset.plan
    cell = max(plan.cell, view.cover.cell if view.cover else 0.0)
    for i in range(1, len(large)):
        frame = large.frame(i, [])
        column = np.flatnonzero(plan.snow(frame.time, frame.points).any(axis=0)).max()
        reached = plan.x0 + plan.cell * column
        assert reached > np.quantile(frame.points[:, 0], 1.0 - STRAYS) - cell
        assert reached < large.history["front"][i] + cell


def test_its_front_on_the_picture_is_that_of_the_run(view, large):
    """Read back from the pixels: east is right."""
    plan, (left, top, right, bottom) = view.inset.plan, box_of(view.inset)
    for i in (2, 4, 6):
        picture = view.picture(i)[top:bottom, left:right].astype(int)
        red = (picture[..., 0] - np.maximum(picture[..., 1], picture[..., 2]) > 40) & (picture[..., 1] < 120)
        reached = plan.x0 + plan.cell * np.flatnonzero(red.any(axis=0)).max()
        assert reached == pytest.approx(large.history["front"][i], abs=plan.cell)


def test_its_track_grows_and_stays(view, large):
    tracks = [view.inset.plan.track(time) for time in large.times]
    assert all((before <= after).all() for before, after in itertools.pairwise(tracks))
    start = large.frame(0, []).points
    row, column, _ = view.inset.plan.pixels(start[:, 0], start[:, 1])
    assert tracks[-1][row, column].mean() > 0.95 and not tracks[0].any()


@pytest.mark.parametrize(("size", "camera"), [(SIZE, "auto"), (SIZE, "follow"), ((360, 640), "auto")])
def test_it_is_small_and_hides_no_moving_snow(large, size, camera):
    view = seen_from(camera, large, size)
    left, top, right, bottom = box_of(view.inset)
    assert (right - left) * (bottom - top) <= 1.02 * AREA * size[0] * size[1]
    assert min(left, top, size[0] - right, size[1] - bottom) >= round(EDGE * unit_of(size))
    for i, time in enumerate(large.times):
        seen = view.camera if view.path is None else view.path.camera(time, size)
        x, y, _ = seen.project(large.frame(i, []).points)
        assert ((x >= left) & (x < right) & (y >= top) & (y < bottom)).mean() <= HIDDEN


def test_where_snow_fills_the_picture_it_stays_away(view, large, monkeypatch):
    points = large.frame(0, []).points
    middle = np.median(points, axis=0)
    near = look_at(np.add(middle, (0.0, 0.1, 12.0)), middle, 0.5, SIZE)
    monkeypatch.setattr(plan_inset, "_seen", lambda _: [(near, points)])
    assert PlanInset.of(view, "auto") is None
    assert PlanInset.of(view, "on") is not None


def test_it_shows_what_the_camera_shows(large):
    """From straight above: the picture's own rectangle, as far as ground is drawn."""
    view = seen_from("top", large)
    plan, inset = view.inset.plan, view.inset
    rows, columns = np.nonzero(plan.shown(view.camera, inset.lower, inset.upper))
    for axis, found, first in ((0, columns, plan.x0), (1, rows, plan.y0)):
        half = 0.5 * SIZE[axis] / view.camera.scale
        low = max(view.camera.eye[axis] - half, inset.lower[axis])
        high = min(view.camera.eye[axis] + half, inset.upper[axis])
        assert first + plan.cell * found.min() == pytest.approx(low, abs=plan.cell)
        assert first + plan.cell * found.max() == pytest.approx(high, abs=plan.cell)
    picture = plan.picture(0.0, large.frame(0, []).points, plan.shown(view.camera, inset.lower, inset.upper))
    assert (picture == VIEW).all(axis=2).any()


def test_other_words_are_refused(large, tmp_path):
    with pytest.raises(InputError, match="inset"):
        render_run(large, tmp_path / "a.png", inset="maybe")


@pytest.mark.slow
def test_on_a_raster_its_front_is_that_of_the_history(tmp_path):
    """As above, along the dip of the release from its first centre of mass, as `front` is measured."""
    scene = load_scene("avalanche_on_raster", {"solver.dx": 3.0, "output.interval": 3.0, "end_time": 24.0})
    run = snowmpm.run(scene, tmp_path / "run")
    start = run.frame(0, []).points.astype(float)
    way = downhill(start) / np.linalg.norm(downhill(start))
    plan = seen_from("auto", run, inset="on").inset.plan
    for i in range(1, len(run)):
        frame, front = run.frame(i, []), float(np.interp(run.times[i], run.history["time"], run.history["front"]))
        row, column = np.nonzero(plan.snow(frame.time, frame.points))
        cells = np.column_stack([plan.x0 + plan.cell * column, plan.y0 + plan.cell * row])
        reached = ((cells - start[:, :2].mean(axis=0)) @ way).max()
        farthest = ((frame.points[:, :2] - start[:, :2].mean(axis=0)) @ way).max()
        assert front - plan.cell < reached < farthest + plan.cell
