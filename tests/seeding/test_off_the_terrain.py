"""What a release that misses its terrain is told: where both are, and the usual mistake that brings them together."""

import json

import numpy as np
import pytest

from snowmpm.errors import InputError
from snowmpm.seeding.region_files import read_features
from snowmpm.seeding.terrain_layer import _why_off
from snowmpm.terrain.reference_system import ReferenceSystem

LV95 = np.array([2_600_000.0, 1_200_000.0]), np.array([2_602_000.0, 1_201_500.0])


@pytest.mark.parametrize(("low", "high", "words"), [
    ([600_100.0, 200_100.0], [600_300.0, 200_200.0], "LV03"),
    ([1_200_100.0, 2_600_100.0], [1_200_300.0, 2_600_300.0], "x and y exchanged"),
    ([7.43, 46.95], [7.44, 46.96], "look like degrees"),
    ([46.95, 7.43], [46.96, 7.44], "look like degrees"),
    ([2_700_000.0, 1_300_000.0], [2_700_100.0, 1_300_100.0], "")])
def test_the_usual_mistakes_are_named(low, high, words):
    why = _why_off(np.array(low), np.array(high), *LV95)
    assert words in why and bool(words) == bool(why)


def geojson(path, corners):
    path.write_text(json.dumps({"type": "FeatureCollection", "features": [
        {"type": "Feature", "properties": {"thickness": 1.0},
         "geometry": {"type": "Polygon", "coordinates": [[*corners, corners[0]]]}}]}))
    return path


def test_latitude_first_is_refused(tmp_path):
    pytest.importorskip("pyproj")
    terrain = ReferenceSystem.named("EPSG:2056", "terrain")
    there = [[7.44, 46.95], [7.45, 46.95], [7.45, 46.96]]
    (feature,) = read_features(geojson(tmp_path / "right.geojson", there), "file", terrain)
    assert np.abs(feature.parts[0][0] - [2.6e6, 1.2e6]).max() < 5e3
    with pytest.raises(InputError, match="longitude first"):
        read_features(geojson(tmp_path / "wrong.geojson", [place[::-1] for place in there]), "file", terrain)
