"""What docs/run_file.md says of sizes is what `tests/benchmarks/file_sizes.py` wrote."""

import csv

import pytest

from snowmpm.io.layout import OVERHEAD, expected_size
from tests.support.project import ROOT

with (ROOT / "tests" / "benchmarks" / "figures" / "file_sizes.csv").open(newline="", encoding="utf-8") as _file:
    ROWS = list(csv.DictReader(_file))
WHOLE = [row for row in ROWS if row["field"] == "all"]


@pytest.mark.parametrize("row", WHOLE, ids=lambda row: row["scene"])
def test_the_document_shows_the_table(row):
    piece = f" {row['piece_ms']} ms |" if row["piece_ms"] else "  |"
    line = (f"| `{row['scene']}`, {int(row['particles']):,} particles | {row['numbers']} | {row['raw']} B |"
            f" {row['stored']} B | {row['frame_ns']} ns |{piece} {row['checkpoint']} B |")
    assert line in (ROOT / "docs" / "run_file.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("row", WHOLE, ids=lambda row: row["scene"])
def test_what_check_foretells_is_enough_and_not_much_more(row):
    foretold = expected_size(3, 1, 10**6, int(row["numbers"])) - OVERHEAD
    assert 1.0 < foretold / 1e6 / float(row["stored"]) < 1.35


def test_fields_add_up():
    for whole in WHOLE:
        parts = [row for row in ROWS if row["scene"] == whole["scene"] and row["field"] != "all"]
        assert sum(int(row["raw"]) for row in parts) == int(whole["raw"])
        assert sum(float(row["stored"]) for row in parts) == pytest.approx(float(whole["stored"]), rel=0.01)
