"""Columns drawn as one sheet: depths and heights on a lattice, snow that thins out, no lattice in a thin tail."""

import numpy as np
import pytest
from scipy import ndimage

from snowmpm.io import Run, RunWriter
from snowmpm.render import light
from snowmpm.render.run_film import view_of
from snowmpm.render.sheet import THIN, sheet_of

SPACING = 2.0


def slope(x, y):
    return 50.0 - 0.5 * np.asarray(x)


def columns(nx, ny, depth, apart=1.0, seed=None):
    """Columns on a lattice, or shifted by half a spacing at most; their depths (n,)."""
    x, y = (g.ravel() for g in np.meshgrid(*(SPACING * apart * np.arange(n) for n in (nx, ny)), indexing="ij"))
    if seed is not None:
        rng = np.random.default_rng(seed)
        x, y = (part + 0.5 * SPACING * apart * rng.uniform(-1.0, 1.0, len(part)) for part in (x, y))
    depths = np.full(len(x), depth)
    return np.column_stack([x, y, slope(x, y) + 0.5 * depths]), depths


def test_a_lattice_of_columns_has_their_depth_and_colour():
    points, depth = columns(20, 20, 1.5)
    colours = np.tile(np.float32([0.2, 0.5, 0.7]), (len(points), 1))
    places, cell, shade = sheet_of(points, depth, SPACING, colours, slope)
    assert cell == SPACING / 2.0 and np.allclose(shade[:, :3], [0.2, 0.5, 0.7], atol=1e-5)
    above = places[:, 2] - slope(places[:, 0], places[:, 1])
    inner = (np.abs(places[:, :2] - 19.0) < 12.0).all(axis=1)
    assert above.min() > 0.0 and set(np.round(above[inner], 4)) == {1.5, 0.5}  # the surface, and a cell below it
    assert (shade[inner, 3] == 1.0).all()
    outside = np.maximum(np.abs(places[:, :2] - 19.0).max(axis=1) - 19.0, 0.0)
    assert outside.max() < 1.5 * SPACING  # the rim of the flow stays where it is


def test_sparse_columns_become_a_thin_sheet_of_their_volume():
    """Twice as far apart each way: a quarter of the depth, evenly, and see-through where that is thin."""
    points, depth = columns(24, 24, THIN * SPACING, apart=2.0)
    places, _, shade = sheet_of(points, depth, SPACING, np.ones((len(points), 3), np.float32), slope)
    surface = (np.abs(places[:, :2] - 46.0) < 30.0).all(axis=1)
    thickness = places[surface, 2] - slope(*places[surface, :2].T)
    assert thickness.mean() == pytest.approx(0.25 * depth[0], rel=0.1)
    assert shade[surface, 3].min() > 0.1 and shade[surface, 3].max() < 0.5
    assert thickness.std() < 0.5 * thickness.mean()


def test_places_without_ground_take_that_of_their_columns():
    points, depth = columns(6, 6, 1.0)
    nowhere = sheet_of(points, depth, SPACING, np.ones((36, 3)), lambda x, y: np.full(np.shape(x), -np.inf))[0]
    known = sheet_of(points, depth, SPACING, np.ones((36, 3)), slope)[0]
    inner = (np.abs(known[:, :2] - 5.0) < 3.0).all(axis=1)
    assert np.allclose(nowhere[inner], known[inner], atol=0.01)


def test_columns_far_apart_make_no_sheet_but_a_coarser_one_first():
    for far, cell in ((1000.0, 1.0), (3.0e3, 2.0), (1.0e6, None)):
        points = np.array([[0.0, 0.0, 0.5], [far, 800.0, 0.5]])
        found = sheet_of(points, np.ones(2), SPACING, np.ones((2, 3)), slope)
        assert found is None if cell is None else found[1] == cell


def test_a_thin_tail_does_not_show_its_columns(tmp_path):
    """Contrast between pixels five apart over the tail of a flow, drawn as a sheet and as single columns."""
    points, depth = columns(40, 12, 0.05, apart=1.8, seed=4)
    corners = np.array([[-40.0, -40.0], [220.0, -40.0], [220.0, 90.0], [-40.0, 90.0]])
    ground = np.column_stack([corners, slope(*corners.T)])
    record = {"particle_spacing": SPACING, "scene_name": "tail"}
    with RunWriter(tmp_path, provenance=record, terrain=(ground, np.array([[0, 1, 2], [0, 2, 3]])), dimension=3) as out:
        for t in (0.0, 1.0):
            out.frame(t, points, {"depth": depth * (t == 0.0)})
    view = view_of(Run(tmp_path), (480, 270), "snow")
    view.plain = True
    x, y, _ = view.camera.project(points)
    inside = np.zeros((270, 480), bool)
    inside[y.astype(int).clip(0, 269), x.astype(int).clip(0, 479)] = True
    inside = ndimage.binary_erosion(ndimage.binary_closing(inside, iterations=12), iterations=14)
    assert inside.sum() > 2000
    rough = {}
    for sheet in (True, False):
        view.as_sheet = sheet
        grey = view.picture(0).astype(float).mean(axis=-1) - light.encode(view.ground.light).astype(float).mean(axis=-1)
        rough[sheet] = (grey - ndimage.gaussian_filter(grey, 6.0))[inside].std()
        assert grey[inside].mean() > 1.0  # it is seen
    view.as_sheet = True
    assert view._frame(1)[1][2] is None  # after a hand-over: particles
    assert rough[True] < 0.2 * rough[False]
