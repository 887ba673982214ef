"""What maps mean for hazard mapping: run-out, travel angle, areas, on a ground where they can be counted."""

import numpy as np
import pytest
import shapely

from snowmpm.quantities.table import NUMBERS
from snowmpm.results import hazard

CELL, SLOPE = 5.0, 0.5
RELEASE = shapely.box(21.0, 80.0, 59.0, 120.0)
"""A metre narrower at its upper and lower end than the map cells that it touches."""


def ground(plan):
    """Falls by SLOPE towards +x as far as x = 400 m, flat beyond."""
    return 1000.0 - SLOPE * np.minimum(plan[:, 0], 400.0)


def straight_avalanche(lone_grain=False, ground=ground):
    """Release over x = 20 to 60 m, flow 40 m wide to x = 500 m, deposit of 1 m from 460 to 500 m."""
    maps = {name: np.zeros((160, 40)) for name in
            ("release_depth", "peak_depth", "peak_speed", "peak_pressure", "deposit_depth")}
    maps["release_depth"][4:12, 16:24] = 1.0
    maps["deposit_depth"][92:100, 16:24] = 1.0
    maps["peak_depth"][4:100, 16:24] = 1.0
    x = CELL * (np.arange(160)[:, None] + 0.5)
    maps["peak_speed"][:] = np.where(maps["peak_depth"] > 0.0, np.minimum(20.0, (500.0 - x) / 5.0), 0.0)
    maps["peak_pressure"][:] = 250.0 * maps["peak_speed"] ** 2
    if lone_grain:
        maps["peak_depth"][150, 20] = maps["deposit_depth"][150, 20] = 0.02
    return hazard.assess(maps, np.zeros(2), CELL, 0.1, {"moving_share": 0.0}, ground, RELEASE)


def test_run_out_and_travel_angle():
    found = straight_avalanche().numbers
    # From the upper edge of the release, at x = 21 m, along the path to 99 % of the way through the deposit
    assert found["runout"] == pytest.approx(460.0 + 0.99 * 40.0 - 22.0, abs=0.6 * CELL)
    assert found["fall"] == pytest.approx(SLOPE * (400.0 - 21.0))
    angle = np.degrees(np.arctan2(found["fall"], found["runout"]))
    assert found["travel_angle"] == pytest.approx(angle) and 20.0 < angle < 23.0
    assert found["top"] == pytest.approx(1000.0 - SLOPE * 21.0) and found["runout_z"] == pytest.approx(800.0)


def test_areas_and_volumes():
    found = straight_avalanche().numbers
    assert found["release_area"] == 38.0 * 40.0 and found["release_volume"] == found["deposit_volume"] == 1600.0
    assert found["affected_area"] == 480.0 * 40.0 and found["deposit_area"] == 1600.0
    # rho v^2 >= 10 kPa where v >= 6.32 m/s: x <= 468 m
    assert found["area_above_10_kPa"] == pytest.approx(40.0 * (470.0 - 20.0))
    assert found["area_above_30_kPa"] < found["area_above_10_kPa"] < found["area_above_1_kPa"]
    assert found["reach_of_10_kPa"] == pytest.approx(470.0 - 22.0, abs=1.0)
    assert found["reach_of_flow"] == pytest.approx(500.0 - 22.0, abs=1.0)
    assert found["largest_flow_pressure"] == pytest.approx(250.0 * 400.0)
    assert set(found) <= {one.name for one in NUMBERS}


def test_a_lone_grain_changes_nothing():
    without, with_it = straight_avalanche().numbers, straight_avalanche(lone_grain=True).numbers
    for name in ("runout", "travel_angle", "affected_area", "reach_of_1_kPa"):
        assert with_it[name] == pytest.approx(without[name], rel=1e-3)


def test_profile_and_line():
    found = straight_avalanche()
    profile = found.profile
    apart = np.diff(profile["s"])
    assert (np.abs(apart - CELL) > 0.01 * CELL).sum() <= 1 and apart.max() < 1.01 * CELL  # one where the path ends
    assert np.allclose(profile["y"], 102.5, atol=CELL)
    flowing = (profile["x"] > 30.0) & (profile["x"] < 490.0)
    assert np.allclose(profile["peak_depth"][flowing], 1.0)
    (x0, y0), (x1, y1) = found.line
    assert x0 == pytest.approx(x1, abs=CELL) and abs(y1 - y0) > 40.0  # across the whole flow
    assert found.record()["runout_line"] is not None


def test_nothing_moved():
    maps = {name: np.zeros((10, 10)) for name in
            ("release_depth", "peak_depth", "peak_speed", "peak_pressure", "deposit_depth")}
    for name in ("release_depth", "peak_depth", "deposit_depth"):
        maps[name][4:6, 4:6] = 1.0
    found = hazard.assess(maps, np.zeros(2), CELL, 0.1, {}, ground,
                          shapely.box(20.0, 20.0, 30.0, 30.0))
    assert "runout" not in found.numbers and found.line is None and found.profile == {}
    assert found.numbers["affected_area"] == 100.0


@pytest.mark.filterwarnings("error")
def test_a_release_over_holes_alone_has_areas_but_no_top():
    found = straight_avalanche(ground=lambda plan: np.full(len(plan), np.nan))
    assert found.numbers["affected_area"] == 480.0 * 40.0 and found.classes
    assert not {"top", "runout", "travel_angle"} & set(found.numbers) and found.line is None and found.profile == {}


@pytest.mark.filterwarnings("error")
def test_the_top_is_that_of_the_ground_there_is():
    found = straight_avalanche(ground=lambda plan: np.where(plan[:, 0] < 30.0, np.nan, ground(plan))).numbers
    assert found["top"] == pytest.approx(1000.0 - SLOPE * 30.0, abs=SLOPE * CELL)


def test_areas_by_class_add_up():
    """480 m by 40 m: at rho v^2 = 250 v^2 with v = min(20, (500 - x) / 5) m/s, 100 kPa as far as x = 400 m."""
    found = straight_avalanche()
    pressure = {row["class"]: row["area"] for row in found.classes["peak_pressure"]}
    assert sum(pressure.values()) == found.numbers["affected_area"]
    assert pressure["100 to 300 kPa"] == pytest.approx(380.0 * 40.0) and pressure["300 kPa and above"] == 0.0
    assert pressure["30 to 100 kPa"] + pressure["100 to 300 kPa"] == found.numbers["area_above_30_kPa"]
    depth = {row["class"]: row["area"] for row in found.classes["peak_depth"]}
    assert depth["1 to 2 m"] == found.numbers["affected_area"] and depth["below 0.5 m"] == 0.0
    assert sum(row["area"] for row in found.classes["deposit_depth"]) == found.numbers["deposit_area"]
