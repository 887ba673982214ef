"""Figures of docs/snow_pits.md beside the tables and constants that they are taken from."""

import csv

from snowmpm.pit import mechanics, scenes
from snowmpm.pit.batch import NEAR_END
from snowmpm.pit.record import NAMES
from tests.support.project import ROOT

GUIDE = (ROOT / "docs" / "snow_pits.md").read_text(encoding="utf-8")


def test_the_table_of_saw_tests_is_that_of_the_file():
    with (ROOT / "tests" / "benchmarks" / "figures" / "snow_pits.csv").open(encoding="utf-8") as file:
        rows = [row for row in csv.DictReader(file) if (row["profiles"], row["tests"]) == ("310", "away_from_the_end")]
    assert len(rows) == 3
    for row in rows:
        line = (f"| {NAMES[row['theory']]} | {row['median_ratio']} | {row['rank_correlation']} |"
                f" {100 * float(row['within_1.5']):.0f} % | {100 * float(row['in_interval']):.0f} % |")
        assert line in GUIDE
    assert f"{rows[-1]['n']} tests that ran to the end" in GUIDE
    assert f"less than {NEAR_END:g} of the column" in GUIDE


def test_scatter_and_choices_are_those_of_the_program():
    assert f"scatter by {100 * mechanics.DENSITY_SCATTER['hardness']:.0f} %" in GUIDE
    assert f"{100 * mechanics.DENSITY_SCATTER['form']:.0f} %" in GUIDE
    assert f"at least {scenes.BEARS:g} times the shear stress" in GUIDE
    assert f"{mechanics.COLLAPSE:g} J/m²" in GUIDE
