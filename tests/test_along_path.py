"""Numbers along a path, beside those of AvaFrame's AIMEC on the same rasters."""

import itertools

import numpy as np
import pytest
import shapely

from snowmpm.errors import InputError
from snowmpm.io.along_path import FURTHER, along_path, extended, sections
from snowmpm.io.ground_maps import Map, Terrain

CELL = 5.0
LINE = np.array([[112.5, 410.0], [500.0, 380.0], [900.0, 520.0], [1250.0, 500.0]])
AIMEC = {"path_pressure": 178572.055594814, "path_thickness": 1.9998094914179456, "path_speed": 29.880767607365332,
         "path_runout": 1015.1445537614462, "path_delta": 1015.1445537614462, "path_fall": 445.64054216867476,
         "path_angle": 23.70109966611678, "path_area": 117563.24160477801}
"""Of avaframe 2.1, ana3AIMEC.aimecTools, with its own settings on these rasters and this line."""


def ground(places):
    return 1500.0 - 0.45 * places[..., 0] - 0.0001 * (places[..., 1] - 450.0) ** 2


def maps(turn=0.0):
    """Maps of a flow that slows down along the line, 40 m wide, on a ridge; turned about the origin by an angle."""
    to = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])  # rows: places are turned by it
    corners = np.array([[0.0, 0.0], [1400.0, 0.0], [0.0, 900.0], [1400.0, 900.0]]) @ to
    low = CELL * np.floor(corners.min(axis=0) / CELL)
    nx, ny = np.ceil((corners.max(axis=0) - low) / CELL).astype(int)
    here = np.stack(np.meshgrid(low[0] + CELL * (np.arange(nx) + 0.5), low[1] + CELL * (np.arange(ny) + 0.5)), axis=-1)
    back = here @ to.T
    line, points = shapely.LineString(LINE), shapely.points(back)
    beside = np.exp(-(shapely.distance(line, points) / 40.0) ** 2)
    speed = 30.0 * beside * np.clip(1.0 - shapely.line_locate_point(line, points) / 1100.0, 0.0, None)
    speed[speed < 0.5] = 0.0
    slope = np.stack([np.full(speed.shape, -0.45), -0.0002 * (back[..., 1] - 450.0)])
    cosine = 1.0 / np.sqrt(1.0 + (slope**2).sum(axis=0))
    thickness = 2.0 * beside * (speed > 0.0)
    values = {"peak_pressure": 200.0 * speed**2, "peak_speed": speed, "peak_thickness": thickness,
              "peak_depth": thickness / cosine}
    found = {name: Map(np.where(speed > 0.0, one, np.nan), *(low + 0.5 * CELL), CELL, "")
             for name, one in values.items()}
    return found, LINE @ to, lambda places: ground(places @ to.T)


def test_the_numbers_are_those_of_aimec():
    found, line, height = maps()
    numbers, beyond = along_path(found, np.zeros(2), line, height)
    assert not beyond
    for name in ("path_pressure", "path_thickness", "path_speed"):
        assert numbers[name] == pytest.approx(AIMEC[name], rel=1e-3)
    for name in ("path_runout", "path_delta"):
        assert numbers[name] == pytest.approx(AIMEC[name], abs=CELL)
    assert numbers["path_fall"] == pytest.approx(AIMEC["path_fall"], abs=0.45 * CELL)
    assert numbers["path_angle"] == pytest.approx(AIMEC["path_angle"], abs=0.05)
    assert numbers["path_area"] == pytest.approx(AIMEC["path_area"], rel=0.02)


def test_the_direction_in_which_a_path_is_drawn_does_not_matter():
    found, line, height = maps()
    assert along_path(found, np.zeros(2), line[::-1], height) == along_path(found, np.zeros(2), line, height)


@pytest.mark.parametrize("degrees", [30.0, 90.0, 200.0])
def test_a_turned_scene_has_the_same_numbers(degrees):
    found, line, height = maps()
    first, _ = along_path(found, np.zeros(2), line, height)
    found, line, height = maps(np.radians(degrees))
    second, _ = along_path(found, np.zeros(2), line, height)
    for name in ("path_runout", "path_delta", "path_fall"):
        assert second[name] == pytest.approx(first[name], abs=CELL)
    for name in ("path_pressure", "path_thickness", "path_area"):
        assert second[name] == pytest.approx(first[name], rel=0.01)


def test_a_flow_further_by_some_cells_runs_out_further_by_as_many():
    found, line, height = maps()
    straight = np.array([line[0], line[0] + [1000.0, 0.0]])
    values = {}
    for shift in (0, 7):
        way = np.zeros((180, 280))
        way[80:86, 22 : 120 + shift] = 5e3
        values[shift] = along_path({"peak_pressure": Map(way, 2.5, 2.5, CELL, "Pa"), "peak_depth": found["peak_depth"]},
                                   np.zeros(2), straight, height)[0]["path_runout"]
    assert values[7] - values[0] == pytest.approx(7 * CELL, abs=0.1 * CELL)


def test_nothing_above_the_pressure():
    found, line, height = maps()
    found["peak_pressure"] = Map(np.minimum(found["peak_pressure"].values, 900.0), 2.5, 2.5, CELL, "Pa")
    numbers, _ = along_path(found, np.zeros(2), line, height)
    assert "path_runout" not in numbers and numbers["path_area"] == 0.0 and numbers["path_pressure"] < 901.0


def test_cross_sections_stand_on_the_path():
    found = sections(LINE, CELL)
    np.testing.assert_allclose(found.middles[[0, -1]], LINE[[0, -1]], atol=1e-9)
    assert found.s[-1] == pytest.approx(np.linalg.norm(np.diff(LINE, axis=0), axis=1).sum(), rel=1e-6)
    assert np.linalg.norm(np.diff(found.places, axis=0), axis=2).max() <= CELL + 1e-9
    across = found.places[:, -1] - found.places[:, 0]
    assert np.abs(np.einsum("ij,j->i", across[:1], LINE[1] - LINE[0])) < 1e-6  # normal to the first piece


def test_a_thalweg_is_extended_straight():
    way = np.concatenate([np.linspace(a, b, 50)[:-1] for a, b in itertools.pairwise(LINE)] + [LINE[-1:]])
    s = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(way, axis=0), axis=1))])
    found = extended({"x": way[:, 0], "y": way[:, 1], "s": s})
    np.testing.assert_array_equal(found[:-1], way)
    further = found[-1] - way[-1]
    assert np.linalg.norm(further) == pytest.approx(FURTHER * s[-1])
    assert further @ (LINE[3] - LINE[2]) == pytest.approx(np.linalg.norm(further) * np.linalg.norm(LINE[3] - LINE[2]))


def test_a_path_that_ends_in_the_flow():
    found, line, height = maps()
    numbers, beyond = along_path(found, np.zeros(2), line[:3], height)
    assert beyond and numbers["path_runout"] == pytest.approx(np.linalg.norm(np.diff(line[:3], axis=0), axis=1).sum())


@pytest.mark.parametrize(("line", "words"), [
    ([[1e6, 0.0], [1e6 + 100.0, 0.0]], "lies beside the maps"), ([[0.0, 0.0], [1e8, 0.0]], "too many"),
    ([[0.0, 0.0], [1e300, 0.0]], "too many"),
])
def test_paths_that_are_refused(line, words):
    found, _, height = maps()
    with pytest.raises(InputError, match=words):
        along_path(found, np.zeros(2), np.array(line), height)


def test_heights_of_the_ground_of_a_run():
    vertices = np.array([[0.0, 0.0, 0.0], [10.0, 0.0, 5.0], [0.0, 10.0, 2.0], [10.0, 10.0, 9.0]])
    ground = Terrain(vertices, np.array([[0, 1, 2], [1, 3, 2]]))
    heights = ground.heights(np.array([[0.0, 0.0], [2.0, 4.0], [10.0, 10.0], [8.0, 8.0], [11.0, 0.0]]))
    np.testing.assert_allclose(heights[:4], [0.0, 1.0 + 0.8, 9.0, 7.2 - 0.4 + 0.2 - 0.4 + 0.2], atol=1e-9)
    assert np.isnan(heights[4])
