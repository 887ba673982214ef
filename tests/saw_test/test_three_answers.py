"""A number of a saw test is a value, did not happen, or cannot be told by its column or its run."""

import numpy as np
import pytest

from snowmpm.advice.report import advise
from snowmpm.errors import InputError
from snowmpm.io.saw_words import in_short, outcome
from snowmpm.quantities.saw import COLUMN_TOO_SHORT, NOT_HAPPENED, REASONS, RUN_TOO_SHORT, VOID
from snowmpm.scenes import load_scene
from snowmpm.setup.refusals import refuse_beyond
from tests.support.saw_records import SAW, found, record, runaway

LATE = {"crack_speed", "top_speed", "collapse_height", "fracture_energy"}


def begins(result, name):
    return next(reason for reason in REASONS if result["reasons"][name].startswith(reason))


@pytest.mark.parametrize(("length", "bins"), [(0.8, 16), (1.0, 20), (1.2, 24)])
def test_a_crack_that_crosses_a_short_column_has_a_critical_length(length, bins):
    """The standard column of the field is 1 m long."""
    result = found(record(runaway, length=length, n=bins, saw_to=length - 0.2))
    assert result["critical_length"] == pytest.approx(0.3, abs=0.05) and result["runs_to_the_end"]
    assert set(result["reasons"]) == LATE
    assert {begins(result, name) for name in LATE} == {COLUMN_TOO_SHORT}
    assert f"has {length:.2f} m" in result["reasons"]["crack_speed"]
    words = outcome(result, None)
    assert words.startswith("critical length 0.2") and "crack speed, top speed: column too short to tell" in words


def test_each_number_is_told_from_its_own_length_on():
    for length, known in ((1.7, set()), (2.0, {"fracture_energy"}), (2.9, LATE - {"collapse_height"}), (3.2, LATE)):
        result = found(record(runaway, length=length, n=round(40 * length), saw_to=1.0))
        assert {name for name in LATE if result[name] is not None} == known, length
        assert set(result["reasons"]) == LATE - known


def test_a_crack_that_begins_beyond_the_middle_of_a_short_column_cannot_be_told_from_the_end_of_the_slab():
    result = found(record(lambda at: at / SAW if at < 0.6 else 0.3 + (at - 0.6) / 30.0, length=1.0, n=20, saw_to=0.8))
    assert result["critical_length"] is None and begins(result, "critical_length") == COLUMN_TOO_SHORT
    assert "at a cut of 0.5" in result["reasons"]["critical_length"]


def test_a_crack_that_pauses_on_a_short_column_does_not_run_by_itself():
    """Its mean speed is that of a runaway crack, and so would a way from begin to end alone say."""
    def paused(at):
        return runaway(at) if at < 0.6 else runaway(at) + 0.04

    result = found(record(paused, length=1.0, n=20, saw_to=0.8))
    assert result["critical_length"] is None or result["critical_length"] > 0.5


@pytest.mark.parametrize(("record_of", "reason"), [
    (lambda: record(lambda at: np.nan, length=1.0, n=20, saw_to=0.1), NOT_HAPPENED),
    (lambda: record(lambda at: runaway(at) if at < 0.7 else np.nan, length=1.0, n=20, saw_to=0.4), NOT_HAPPENED),
    (lambda: record(lambda at: max(at - 0.1, 0.0) / SAW if at < 1.1 else np.nan), NOT_HAPPENED),
    (lambda: record(runaway, length=1.0, n=20, until=0.165, saw_to=0.8), RUN_TOO_SHORT),
    (lambda: record(runaway, until=0.17), RUN_TOO_SHORT),
    (lambda: record(lambda at: np.nan, until=0.08, saw_to=0.4), RUN_TOO_SHORT),
    (lambda: {**record(runaway), "broken_at_rest": np.ones(240)}, VOID),
], ids=["uncut", "stops on 1 m", "follows the saw", "on its way, 1 m", "on its way, 6 m", "sawing", "void"])
def test_no_critical_length(record_of, reason):
    result = found(record_of())
    assert result["critical_length"] is None and begins(result, "critical_length") == reason
    assert in_short(result, "critical_length") == REASONS[reason]
    assert result["reasons"]["critical_length"] in outcome(result, None)


def test_a_crack_that_stops_or_is_on_its_way_says_so_of_its_later_numbers():
    stood = found(record(lambda at: runaway(at) if at < 1.9 else np.nan))
    assert stood["critical_length"] is not None and stood["stopped"] is True
    assert begins(stood, "crack_speed") == NOT_HAPPENED and "stopped at 1.90 m" in stood["reasons"]["crack_speed"]
    going = found(record(runaway, until=0.2))
    assert going["critical_length"] is not None and begins(going, "crack_speed") == RUN_TOO_SHORT


def test_the_jump_at_the_free_end_is_no_speed_of_the_crack():
    """The last D breaks at once, and the bins before it ever faster."""
    def jumping(at):
        return runaway(min(at, 5.2)) + max(at - 5.2, 0.0) / 400.0

    result = found(record(jumping))
    assert result["crack_speed"] == pytest.approx(30.0, rel=0.02) and result["crack_speed_spread"] < 2.0
    assert result["top_speed"] == pytest.approx(30.0, rel=0.05)


def test_a_second_crack_ahead_of_the_tip_is_no_speed_of_the_first():
    def two(at):
        return min(runaway(at), runaway(4.4) - 0.03 + abs(at - 4.4) / 30.0) if at > 3.9 else runaway(at)

    result = found(record(two))
    assert result["crack_speed"] == pytest.approx(30.0, rel=0.03) and result["crack_speed_spread"] < 4.0


def test_check_says_before_what_a_column_cannot_tell():
    def warned(**changes):
        return [str(one) for one in advise(load_scene("pst_2d", changes)).cautions]

    assert not warned()
    short = warned(**{"saw_test.length": 1.0, "saw_test.saw_length": 0.8})
    assert len(short) == 1 and "too short to tell crack speed, collapse height, fracture energy" in short[0]
    length = float(short[0].rpartition("saw_test.length = ")[2])
    assert not warned(**{"saw_test.length": length, "saw_test.saw_length": 0.8})
    late = warned(end_time=0.08)
    assert len(late) == 1 and late[0].startswith("end_time: 0.08 s: the saw is then at 0.12 of 1 m")
    assert not warned(end_time=float(late[0].rpartition("end_time = ")[2]))


def test_the_precision_asked_for_is_the_width_of_the_bins():
    assert load_scene("pst_2d", {"saw_test.resolution": 0.03}).saw_test.resolution == 0.03
    with pytest.raises(InputError, match=r"saw_test\.resolution = 0\.01: must be at least 0\.025"):
        refuse_beyond(load_scene("pst_2d", {"saw_test.resolution": 0.01}))
    with pytest.raises(InputError, match=r"saw_test\.resolution = 9\.0: must be at most length = 6"):
        load_scene("pst_2d", {"saw_test.resolution": 9.0})
