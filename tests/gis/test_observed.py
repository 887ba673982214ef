"""Scores against an observed outline, of rectangles that can be counted."""

import numpy as np
import pytest
import shapely

from snowmpm.errors import InputError
from snowmpm.gis.observed import Observed, compare, read_observed, score
from snowmpm.terrain.reference_system import ReferenceSystem
from tests.support.straight_avalanche import ORIGIN


def test_scores_of_two_rectangles():
    profile = {"x": np.arange(0.0, 301.0, 35.0), "y": np.full(9, 20.0)}  # its points are coarser than the difference
    found = compare(shapely.box(0.0, 0.0, 200.0, 40.0), shapely.box(50.0, 20.0, 250.0, 60.0), profile)
    hit, missed, false = 150.0 * 20.0, 200.0 * 40.0 - 3000.0, 200.0 * 40.0 - 3000.0
    assert (found["hit_area"], found["missed_area"], found["false_area"]) == (hit, missed, false)
    assert found["critical_success_index"] == pytest.approx(3.0 / 13.0) and found["hit_rate"] == 0.375
    assert found["false_alarm_ratio"] == 0.625 and found["area_ratio"] == 1.0
    assert found["runout_difference"] == pytest.approx(-50.0)


def test_the_same_outline_scores_one_and_a_disjoint_one_zero():
    area = shapely.box(0.0, 0.0, 10.0, 10.0)
    same, apart = compare(area, area), compare(area, shapely.box(20.0, 0.0, 30.0, 10.0))
    assert same["critical_success_index"] == same["hit_rate"] == same["area_ratio"] == 1.0
    assert same["false_alarm_ratio"] == 0.0
    assert apart["critical_success_index"] == apart["hit_rate"] == 0.0 and apart["false_alarm_ratio"] == 1.0


def test_each_outline_of_a_run_is_scored(straight):
    """Seen: the flow without its last 100 m; above 10 kPa it went to x = 300 m only."""
    x, y = ORIGIN[:2]
    seen = Observed("a", shapely.box(x + 20, y + 80, x + 400, y + 120))
    rows = {row["outline"]: row for row in score(straight, seen)}
    assert set(rows) == {"affected area", "above 1 kPa", "above 3 kPa", "above 10 kPa", "above 30 kPa"}
    whole, strong = rows["affected area"], rows["above 10 kPa"]
    assert whole["hit_area"] == 380.0 * 40.0 - 100.0 and whole["missed_area"] == 100.0  # the hole
    assert whole["false_area"] == 4000.0 and whole["runout_difference"] == pytest.approx(100.0, abs=1.0)
    numbers = straight.hazard["numbers"]
    assert whole["observed_reach"] == numbers["reach_of_flow"] - whole["runout_difference"]
    assert "computed_reach" not in whole  # one reach a threshold
    assert strong["false_area"] == 0.0 and strong["runout_difference"] == pytest.approx(-100.0, abs=1.0)


def test_an_outline_beside_the_maps_is_refused(straight, tmp_path):
    shapefile = pytest.importorskip("shapefile")
    corners = np.array([[20.0, 80.0], [20.0, 120.0], [500.0, 120.0], [500.0, 80.0]]) + ORIGIN[:2] + [3e5, 0.0]
    with shapefile.Writer(str(tmp_path / "far")) as writer:
        writer.field("name", "C")
        writer.poly([corners.tolist()])
        writer.record("far")
    (tmp_path / "far.prj").write_text(straight.provenance["crs"])
    with pytest.raises(InputError, match="km beside the maps"):
        read_observed(tmp_path / "far.shp", straight)


def test_a_shapefile_in_another_projection_is_carried_over(straight, tmp_path):
    shapefile = pytest.importorskip("shapefile")
    corners = np.array([[20.0, 80.0], [20.0, 120.0], [500.0, 120.0], [500.0, 80.0]]) + ORIGIN[:2]
    own = ReferenceSystem.of_text(straight.provenance["crs"], "run")
    utm = ReferenceSystem.named("EPSG:32632", "utm")
    with shapefile.Writer(str(tmp_path / "seen")) as writer:
        writer.field("name", "C")
        writer.poly([own.carried(corners, utm).tolist()])
        writer.record("seen")
    (tmp_path / "seen.prj").write_text(utm.wkt)
    found = score(straight, read_observed(tmp_path / "seen.shp", straight))[0]
    assert found["critical_success_index"] == pytest.approx(1.0 - 100.0 / (480.0 * 40.0), abs=1e-3)
