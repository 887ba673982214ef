"""What was chosen on scenes that no error was measured on, from the table of tests/benchmarks/model_choices.py."""

import csv
from pathlib import Path

import pytest

from snowmpm.ladder.problems import PROBLEMS
from snowmpm.measured import models
from tests.benchmarks.model_choices import FILE, UNSEEN

GUIDE = Path(__file__).parents[2] / "docs" / "models.md"


@pytest.fixture(scope="module")
def rows():
    with FILE.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def test_eight_scenes_that_are_not_in_the_table(rows):
    assert [row["scene"] for row in rows] == [one.name for one in UNSEEN] and len(rows) >= 8
    known = {(one.scene, tuple(sorted(map(str, one.changes.items())))) for one in PROBLEMS.values()}
    assert not known & {(one.scene, tuple(sorted(map(str, one.changes.items())))) for one in UNSEEN}


def test_the_intervals_are_those_of_the_shipped_table(rows):
    for row in rows:
        expected = models.expected_of(models.rows_of(row["question"], row["rung"]))
        assert float(row["low"]) == pytest.approx(expected.low, abs=2e-3)
        assert float(row["high"]) == pytest.approx(expected.high, abs=2e-3)


def test_errors_lie_within_the_promised_interval_in_seven_of_eight(rows):
    for row in rows:
        error = float(row["value"]) / float(row["finest_value"]) - 1.0
        assert error == pytest.approx(float(row["error"]), abs=2e-3)
        assert (row["inside"] == "yes") == (float(row["low"]) <= float(row["error"]) <= float(row["high"]))
    assert sum(row["inside"] == "yes" for row in rows) >= 7


def test_six_take_at_most_a_tenth_of_the_finest_time(rows):
    shares = [float(row["seconds"]) / float(row["finest_seconds"]) for row in rows]
    assert sum(share <= 0.1 for share in shares) >= 6


def test_the_guide_has_every_row(rows):
    text = GUIDE.read_text(encoding="utf-8")
    for row in rows:
        assert (f"| {row['scene']} | {row['question']} | {float(row['within']):.0%} | {row['rung']} |"
                f" {float(row['low']):+.0%} to {float(row['high']):+.0%} | {float(row['error']):+.0%} |"
                f" {float(row['seconds']):.0f} of {float(row['finest_seconds']):.0f} |") in text, row["scene"]
