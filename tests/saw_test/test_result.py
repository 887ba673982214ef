"""Numbers of a saw test from records made by hand."""

from types import SimpleNamespace

import numpy as np
import pytest

from snowmpm.io.saw_words import not_to_the_end, outcome
from snowmpm.saw_test.result import crack_speed
from tests.support.saw_records import SAW, D, found, record, runaway


def test_crack_that_runs():
    result = found(record(runaway))
    assert result["critical_length"] == pytest.approx(0.3, abs=0.03)
    assert result["crack_speed"] == pytest.approx(30.0, rel=0.01)
    assert result["top_speed"] == pytest.approx(30.0, rel=0.05)
    assert result["runs_to_the_end"] and result["crack_length"] == pytest.approx(6.0)
    assert result["collapse_height"] == pytest.approx(1.2e-3) and result["fracture_energy"] == pytest.approx(0.9)
    assert result["plastic_work"] == 5.0


def test_crack_that_only_follows_the_saw():
    result = found(record(lambda at: max(at - 0.1, 0.0) / SAW if at < 1.1 else np.nan))
    assert result["critical_length"] is None and result["crack_speed"] is None and not result["runs_to_the_end"]
    assert result["crack_length"] == pytest.approx(1.1, abs=0.03)


def test_crack_that_jumps_ahead_and_stops():
    """A leap of one slab thickness is no crack that runs by itself."""
    assert found(record(lambda at: runaway(at) if at < 0.8 else np.nan))["critical_length"] is None


def test_crack_that_stops_later():
    result = found(record(lambda at: runaway(at) if at < 3.0 else np.nan))
    assert result["critical_length"] == pytest.approx(0.3, abs=0.03) and not result["runs_to_the_end"]
    assert result["crack_length"] == pytest.approx(3.0, abs=0.03)
    assert result["crack_speed"] == pytest.approx(30.0, rel=0.01)


def test_a_crack_that_stands_still_has_stopped_and_one_on_its_way_has_not():
    about = {"length": 6.0, "normal_stress": 860.0}
    theory = {"theory": {"maxwell_load": 740.0}}
    stood = found(record(lambda at: runaway(at) if at < 3.0 else np.nan, until=0.30))
    going = found(record(runaway, until=0.24))
    assert stood["stopped"] is True and going["stopped"] is False and found(record(runaway))["stopped"] is False
    test = SimpleNamespace(about=about)
    words = outcome({**stood, **theory}, test)
    assert "stopped at 3.00 m of 6 m, under 860 Pa normal stress, above Maxwell's load 740 Pa" in words
    assert "still on its way" in outcome(going, test) and "longer end_time" in not_to_the_end(going, test)
    assert not_to_the_end(found(record(runaway)), test) is None
    assert not_to_the_end(found(record(lambda at: np.nan)), test) is None


def test_numbers_say_how_well_they_are_known():
    result = found(record(runaway))
    assert result["critical_length_resolution"] == pytest.approx(6.0 / 240)
    row = 0.6 / 1200
    assert 30.0**2 * row / D <= result["crack_speed_spread"] < 2.0
    assert "critical length 0.29 ± 0.02 m, crack speed 30 ± 1 m/s" in outcome(result, None)
    # A crack that speeds up scatters more than the record resolves
    faster = found(record(lambda at: at / SAW if at < 0.3 else 0.15 + np.sqrt(0.02 * (at - 0.3))))
    assert faster["crack_speed_spread"] > 1.5 * result["crack_speed_spread"]


def test_crack_that_meets_another_one():
    """The second starts at the far end: the speed is that of the first."""
    meeting = found(record(lambda at: min(runaway(at), 0.2 + (6.0 - at) / 60.0)))
    assert meeting["crack_speed"] == pytest.approx(30.0, rel=0.02) and meeting["runs_to_the_end"]


def test_crack_that_speeds_up():
    """x = x0 + a t^2 / 2: the speed at x is sqrt(2 a (x - x0))."""
    a = 100.0
    values = record(lambda at: at / SAW if at < 0.3 else 0.15 + np.sqrt(2.0 * (at - 0.3) / a))
    x, speed = crack_speed(values["x"], values["arrival"], 0.2)
    far = x > 1.5
    np.testing.assert_allclose(speed[far], np.sqrt(2.0 * a * (x[far] - 0.3)), rtol=0.01)


def test_a_column_that_broke_before_it_was_cut_has_no_critical_length():
    values = record(runaway)
    assert found({**values, "broken_at_rest": np.zeros(len(values["x"]))})["critical_length"] is not None
    result = found({**values, "broken_at_rest": np.ones(len(values["x"]))})
    assert result["critical_length"] is None and result["crack_speed"] is None and result["broken_at_rest"] == 1.0
    assert "had broken over 100% of the column" in outcome(result, values)
