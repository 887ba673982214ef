"""Pictures of saw tests show ground, saw and a scale."""

import numpy as np
import pytest
from synthetic_runs import saw_column, slab_2d

import snowmpm
from snowmpm.io import Run
from snowmpm.render.floor import ground_of
from snowmpm.render.overlay import INK
from snowmpm.render.run_film import view_of
from snowmpm.render.saw_blade import SawBlade
from snowmpm.render.upright import upright
from snowmpm.scenes import load_scene

SIZE = (640, 256)
WEAK = 0.05
"""Thickness of the weak layer on the grid of these runs [m]."""


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    folders = {(dimension, slope): tmp_path_factory.mktemp("saw") for dimension in (2, 3) for slope in (0.0, 30.0)}
    for (dimension, slope), folder in folders.items():
        saw_column(folder, dimension, slope=slope)
    return {key: Run(folder) for key, folder in folders.items()}


@pytest.fixture(scope="module")
def drawn(runs):
    """Each run with its view and the picture of its second frame."""
    views = {key: view_of(run, SIZE, "snow") for key, run in runs.items()
             if key != (3, 30.0)}
    return {key: (view, view.picture(1)) for key, view in views.items()}


def at(view, picture, place):
    """Pixels (n, 3) around a place (3,) in space."""
    camera = view.track.camera(0) if view.run.dimension == 2 else view.camera
    x, y, _ = camera.project(np.array([place]))
    row, column = int(y[0]), int(x[0])
    return picture[row - 1 : row + 2, column - 1 : column + 2].reshape(-1, 3).astype(int)


def slate(pixels):
    """Share of pixels of a solid: bluish, and darker than the sky."""
    return ((pixels[:, 2] - pixels[:, 0] > 15) & (pixels[:, 2] < 185)).mean()


def earth(pixels):
    """Share of pixels of the ground: not bluish, and darker than snow."""
    return ((pixels[:, 0] >= pixels[:, 2]) & (pixels[:, 0] < 200)).mean()


def snow(pixels):
    """Share of pixels of snow: as good as white."""
    return (pixels.min(axis=1) > 150).mean()


@pytest.mark.parametrize("dimension", [2, 3])
def test_the_column_stands_on_ground(drawn, dimension):
    view, picture = drawn[dimension, 0.0]
    ground = ground_of(view.run)
    assert (ground.vertices[:, 0].min(), ground.vertices[:, 0].max()) == (-1.0, 3.0)
    assert (ground.vertices[:, 2] == 0.0).all()
    place = [0.0, -0.06] if dimension == 2 else [0.3 * view.near, 0.0]
    for x in (1.2, 1.4, 1.6):
        assert earth(at(view, picture, [x, *place])) > 0.7


@pytest.mark.parametrize("slope", [0.0, 30.0, -20.0])
def test_the_blade_ends_where_the_cut_does(tmp_path, slope):
    """Slate behind the edge in the layer that was cut, snow before it."""
    saw_column(tmp_path, 2, slope=slope)
    view = view_of(Run(tmp_path), SIZE, "snow", "side")
    view.plain = True
    turn = view.run.turn if slope else np.eye(3)
    for i, edge in ((1, 0.5), (2, 1.0)):
        assert (view.solids(i)[0] @ turn)[:, 0].max() == pytest.approx(edge)
        picture = view.picture(i)
        behind, ahead, opened = (turn @ [edge + x, 0.0, 0.5 * WEAK] for x in (-0.05, 0.05, -0.2))
        assert slate(at(view, picture, behind)) > 0.7
        assert snow(at(view, picture, ahead)) > 0.7
        assert slate(at(view, picture, opened)) == 0.0


def test_in_space_the_saw_stands_out_of_the_column(drawn):
    view, first = drawn[3, 0.0]
    out = 0.15 + 0.10
    for picture, edge in ((first, 0.5), (view.picture(2), 1.0)):
        assert slate(at(view, picture, [edge - 0.06, view.near * out, 0.5 * WEAK])) > 0.7
        assert slate(at(view, picture, [edge + 0.2, view.near * out, 0.5 * WEAK])) == 0.0


@pytest.mark.parametrize("key", [(2, 0.0), (3, 0.0), (2, 30.0)])
def test_there_is_a_scale(drawn, key):
    """A bar in ink, in a lower corner, of a round length."""
    view, picture = drawn[key]
    ink = (np.abs(picture[SIZE[1] * 3 // 4 :].astype(int) - INK).max(axis=2) < 12)
    longest = max(longest_run(row) for row in ink)
    scale = view.action.size_in(view.camera) if key[0] == 3 else view.track.camera(1).scale
    length = longest / scale
    power = 10.0 ** np.floor(np.log10(length))
    assert min(abs(length - m * power) for m in (1.0, 2.0, 5.0, 10.0)) < 3.0 / scale


def longest_run(row):
    """Length of the longest stretch that is true."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], row.astype(int), [0]])))
    return int((edges[1::2] - edges[::2]).max(initial=0))


def test_slopes_are_drawn_as_slopes(runs):
    """x rises towards where the saw goes, at the slope angle; gravity of the run's frame points down."""
    for dimension in (2, 3):
        run = upright(runs[dimension, 30.0])
        points, first = run.frame(2, []).points, runs[dimension, 30.0].frame(2, []).points
        base = points[first[:, 2] < 0.02]
        assert np.polyfit(base[:, 0], base[:, 2], 1)[0] == pytest.approx(np.tan(np.radians(30.0)), abs=1e-3)
        gravity = np.array([[-np.sin(np.radians(30.0)), 0.0, -np.cos(np.radians(30.0))]])
        assert run.turned(gravity)[0] == pytest.approx([0.0, 0.0, -1.0])
        assert upright(runs[dimension, 0.0]) is runs[dimension, 0.0]
        assert upright(run) is run


def test_it_is_where_the_record_of_the_run_has_it(runs):
    blade = SawBlade.of(runs[2, 0.0])
    assert [blade.edge(time) for time in (0.0, 1.0, 1.5, 2.0, 9.0)] == pytest.approx([0.0, 0.5, 0.75, 1.0, 1.0])
    assert (blade.bottom, blade.thickness) == (0.0, pytest.approx(WEAK))


def test_other_runs_have_no_saw(tmp_path):
    slab_2d(tmp_path, frames=2)
    run = Run(tmp_path)
    assert SawBlade.of(run) is None
    assert ground_of(run) is run.terrain


@pytest.mark.slow
@pytest.mark.parametrize("name", ["pst", "pst_2d"])
@pytest.mark.parametrize("slope", [0.0, 30.0])
def test_saw_tests_of_the_library(name, slope, tmp_path):
    """Ground below and saw at the end of the cut, in the middle of a run."""
    scene = load_scene(name, {"end_time": 0.15, "output.interval": 0.05, "saw_test.length": 2.0,
                              "saw_test.slope_angle": slope, "solver.dx": 0.05})
    run = snowmpm.run(scene, tmp_path / "run")
    view = view_of(run, SIZE, "snow")
    picture, i = view.picture(len(run) - 1), len(run) - 1
    edge = float(np.interp(run.times[i], run.saw_test["time"], run.saw_test["saw"]))
    assert edge == pytest.approx(2.0 * (run.times[i] - 0.02), abs=0.05)
    turn = view.run.turn if slope else np.eye(3)
    flat = run.dimension == 2
    blade = [edge - 0.06, 0.0 if flat else 0.25 * view.near, 0.05]
    ground = [1.5, 0.0 if flat else 0.3 * view.near, -0.05 if flat else 0.0]
    assert slate(at(view, picture, turn @ (blade - run.origin))) > 0.5
    assert earth(at(view, picture, turn @ (ground - run.origin))) > 0.5
