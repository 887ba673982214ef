"""Outlines of rasters: areas that can be counted in cells, holes, places."""

import numpy as np
import pytest

from snowmpm.gis.layers import layers_of
from snowmpm.gis.outlines import outline
from snowmpm.io import Map
from tests.support.straight_avalanche import ORIGIN


def test_area_and_place_of_cells():
    mask = np.zeros((6, 8), bool)
    mask[1:4, 2:7] = True
    mask[2, 4] = False  # a hole
    mask[5, 7] = True  # touches nothing
    mask[4, 7] = True
    found = outline(mask, Map(np.zeros(mask.shape), 4.0, 6.0, 8.0, "m"), np.array([1000.0, 2000.0, 0.0]))
    assert found.area == (14 + 2) * 64.0 and found.is_valid
    assert found.bounds == (1016.0, 2010.0, 1064.0, 2050.0)
    assert sorted(len(part.interiors) for part in found.geoms) == [0, 1]


@pytest.mark.parametrize("share", [0.2, 0.5, 0.8])
def test_area_is_that_of_the_cells_whatever_the_shape(share):
    mask = np.random.default_rng(5).random((40, 50)) < share
    cell, origin = 4.997678230579, np.array([247323.244, 350705.85, 0.0])
    found = outline(mask, Map(np.zeros(mask.shape), 0.0, 0.0, cell, "m"), origin)
    assert found.is_valid and found.area == pytest.approx(mask.sum() * cell**2, rel=1e-6)


def test_layers_of_a_run_have_the_areas_of_its_table(straight):
    layers = {layer.name: layer for layer in layers_of(straight)}
    assert list(layers) == ["affected_area", "pressure_classes", "release", "deposit", "thalweg", "runout_line",
                            "runout_point"]
    numbers = straight.hazard["numbers"]
    area, fields = layers["affected_area"].features[0]
    assert area.area == fields["area_m2"] == numbers["affected_area"] == (96 * 8 - 4) * 25.0
    assert sum(len(part.interiors) for part in area.geoms) == 1
    assert layers["release"].features[0][0].area == pytest.approx(numbers["release_area"])
    assert layers["deposit"].features[0][0].area == numbers["deposit_area"]
    west, south, east, north = layers["release"].features[0][0].bounds
    assert (west, south, east, north) == (ORIGIN[0] + 20.0, ORIGIN[1] + 80.0, ORIGIN[0] + 60.0, ORIGIN[1] + 120.0)
    classes = {fields["class"]: geometry.area for geometry, fields in layers["pressure_classes"].features}
    table = {row["class"]: row["area"] for row in straight.hazard["classes"]["peak_pressure"] if row["area"]}
    assert classes == table == {"3 to 10 kPa": 40 * 8 * 25.0, "30 to 100 kPa": (56 * 8 - 4) * 25.0}
    point = layers["runout_point"].features[0][0]
    assert (point.x, point.y, point.z) == (numbers["runout_x"], numbers["runout_y"], numbers["runout_z"])
    way, line = layers["thalweg"].features[0][0], layers["runout_line"].features[0][0]
    assert way.distance(point) < 1e-3 and line.distance(point) < 1e-3
    assert all(fields["final"] and fields["status"].startswith("final: at rest when it ended, at 40 s")
               for layer in layers.values() for _, fields in layer.features)
