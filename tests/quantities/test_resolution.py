"""Published numbers carry what they are known to, and no more digits."""

import math

import pytest

from snowmpm.quantities.resolution import published, resolutions, rounded
from snowmpm.quantities.table import quantity


def test_places_and_lengths_are_known_to_half_a_cell():
    numbers = {"runout": 1923.4, "fall": 1088.2, "travel_angle": 29.5, "runout_x": 600685.3101236074,
               "runout_z": 912.34, "affected_area": 250000.0, "release_area": 5000.0, "largest_flow_speed": 41.23456,
               "reach_of_1_kPa": 1999.9}
    known = resolutions(numbers, 10.0)
    assert known["runout"] == known["runout_x"] == known["reach_of_1_kPa"] == 5.0
    assert known["runout_z"] == pytest.approx(5.0 * 1088.2 / 1923.4)
    steep = 1088.2 / 1923.4
    by_hand = math.degrees(math.atan((1088.2 + known["fall"]) / 1923.4)) - math.degrees(math.atan(steep))
    assert known["travel_angle"] == pytest.approx(math.sqrt(2.0) * by_hand, rel=0.01)
    assert known["affected_area"] == pytest.approx(4.0 * 500.0 * 5.0)
    assert not {"release_area", "largest_flow_speed"} & known.keys()
    found = published(numbers, 10.0)
    assert (found["runout_x"], found["runout"], found["largest_flow_speed"]) == (600685.0, 1923.0, 41.23)
    assert found["affected_area"] == 250000.0 and found["travel_angle"] == 29.5


def test_digits_follow_the_resolution():
    assert rounded(600685.3101236074, 5.0) == 600685.0 and rounded(600685.31, 20.0) == 600690.0
    assert rounded(12.34567, 0.05) == 12.35 and rounded(True) is True and math.isnan(rounded(math.nan, 1.0))
    assert quantity("runout").text(1923.4, 5.0) == "1923 ± 5 m" and quantity("runout").text(1923.4) == "1923 m"
    assert quantity("travel_angle").text(29.4712, 0.12) == "29.5 ± 0.1°"
    assert quantity("runout_x").text(600685.31, 20.0) == "600690 ± 20 m"
    assert quantity("largest_flow_pressure").text(331800.0, 1.2e5) == "300 ± 100 kPa"
    assert quantity("affected_area").text(93500.0, 1.3e4) == "90\u202f000 ± 10\u202f000 m²"
    assert quantity("moving_share").text(0.1234, 0.02) == "12 ± 2 %"
