"""A terrain that is not what it should be is used as far as it goes, and said."""

import numpy as np
import pytest
import trimesh

from snowmpm.terrain import load_terrain
from tests.support.tables import Table


@pytest.fixture
def tilted():
    """(vertices (36, 3), triangles (50, 3)) of a slope."""
    x, y = np.meshgrid(np.arange(6.0), np.arange(6.0), indexing="ij")
    i = np.arange(30).reshape(5, 6)[:, :5].ravel()
    triangles = np.concatenate([np.stack([i, i + 6, i + 7], 1), np.stack([i, i + 7, i + 1], 1)])
    return np.column_stack([x.ravel(), y.ravel(), 3.0 - 0.5 * x.ravel()]), triangles


def warned(recwarn, tmp_path, vertices, triangles):
    trimesh.Trimesh(vertices, triangles, process=False).export(tmp_path / "slope.stl")
    surface = load_terrain(Table(kind="mesh", file="slope.stl"), tmp_path)
    return surface, [str(one.message).partition(": ")[2] for one in recwarn if one.category is UserWarning]


def test_a_good_mesh_is_read_in_silence(recwarn, tmp_path, tilted):
    assert warned(recwarn, tmp_path, *tilted)[1] == []


def test_all_the_other_way_is_only_another_convention(recwarn, tmp_path, tilted):
    assert warned(recwarn, tmp_path, tilted[0], tilted[1][:, ::-1])[1] == []


def test_holes(recwarn, tmp_path, tilted):
    vertices, triangles = tilted
    middle = np.flatnonzero((np.abs(vertices[triangles].mean(axis=1)[:, :2] - 2.5) < 0.5).all(axis=1))
    surface, told = warned(recwarn, tmp_path, vertices, np.delete(triangles, middle, axis=0))
    assert told == ["1 hole, where nothing is carried"]
    assert np.isnan(surface.height([[2.5, 2.5]])).all()


def with_sheet(tilted, x, y, lift):
    """The slope with two more triangles, a rectangle over it `lift` [m] higher than its lower end at x = 5."""
    vertices, triangles = tilted
    corners = [[x[0], y[0]], [x[1], y[0]], [x[1], y[1]], [x[0], y[1]]]
    sheet = np.column_stack([corners, np.full(4, 0.5 + lift)])
    n = len(vertices)
    return np.concatenate([vertices, sheet]), np.concatenate([triangles, [[n, n + 1, n + 2], [n, n + 2, n + 3]]])


@pytest.mark.parametrize(("x", "y", "number"), [([0.0, 5.0], [0.0, 5.0], 52), ([2.25, 2.45], [3.05, 3.15], 2)],
                         ids=["a roof", "a scrap smaller than what it is over"])
def test_triangles_that_hover_over_others(recwarn, tmp_path, tilted, x, y, number):
    surface, told = warned(recwarn, tmp_path, *with_sheet(tilted, x, y, lift=4.0))
    assert told[0].startswith(f"{number} triangles over or under others, ")
    gap, place = surface.layers()
    where = place[gap.argmax()]
    assert f"{gap.max():.3g} m apart at x = {where[0]:.10g}, y = {where[1]:.10g}: an overhang or" in told[0]
    assert gap.max() == pytest.approx(4.5 - (3.0 - 0.5 * where[0]))
    assert surface.height([where]) == pytest.approx(4.5)


def test_a_cliff_is_no_second_layer(recwarn, tmp_path):
    """An upright wall between two floors covers no plan."""
    corners = [(0, 0), (2, 4), (2, 0), (4, 0)]  # x, z along the way
    vertices = np.array([[x, y, z] for x, z in corners for y in (0.0, 3.0)])
    triangles = [[2 * k + a for a in t] for k in range(3) for t in ([0, 2, 3], [0, 3, 1])]
    assert warned(recwarn, tmp_path, vertices, np.array(triangles))[1] == []


def test_flipped_and_repeated(recwarn, tmp_path, tilted):
    vertices, triangles = tilted
    triangles[3:7] = triangles[3:7, ::-1]
    surface, told = warned(recwarn, tmp_path, vertices, np.concatenate([triangles, triangles[10:13]]))
    assert told == ["4 triangles that faced the other way, turned; 3 triangles twice or without area, left out"]
    assert (surface.facet_normals[:, 2] > 0).all() and len(surface.facets) == 50


def test_no_data(recwarn, tmp_path):
    rows = np.full((5, 5), 2.0)
    rows[2, 3] = -9999
    text = "ncols 5\nnrows 5\nxllcorner 0\nyllcorner 0\ncellsize 1\nNODATA_value -9999\n"
    (tmp_path / "dem.asc").write_text(text + "\n".join(" ".join(f"{v:g}" for v in row) for row in rows) + "\n")
    load_terrain(Table(kind="dem", file="dem.asc"), tmp_path)
    assert [str(one.message).partition(": ")[2] for one in recwarn if one.category is UserWarning] == [
        "1 of 25 cells without data amid others, where nothing is carried"]
