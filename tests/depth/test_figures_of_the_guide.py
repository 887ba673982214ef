"""Tables of the guide of depth-averaged avalanches: those that the benchmarks wrote."""

import csv
import re
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]
GUIDE = (ROOT / "docs" / "depth_averaged.md").read_text(encoding="utf-8")
PATHS = ("avaGar", "avaAlr", "CoulombOnly", "IdealizedTopo")
WAYS = ("volumes", "columns", "MoT-Voellmy", "com1DFA")


def figures(name):
    with (ROOT / "tests" / "benchmarks" / "figures" / name).open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def measured(path, way, cell=5.0):
    """Areas [ha] beyond 0.1, 0.5, 1 and 2 m."""
    row = next(row for row in figures("depth_areas.csv")
               if (row["path"], row["way"], float(row["cell"])) == (path, way, cell))
    return np.array([float(row[f"area_{least}"]) for least in ("0.1", "0.5", "1", "2")])


def over_peers(path):
    """Areas by finite volumes over the mean of the two peers, less 1."""
    return measured(path, "volumes") / (0.5 * (measured(path, "MoT-Voellmy") + measured(path, "com1DFA"))) - 1.0


@pytest.mark.parametrize("path", PATHS)
def test_areas_beside_two_peers(path):
    cells = re.search(rf"^\| {path} \| (\d+\.\d,.*) \|$", GUIDE, re.MULTILINE)[1].split(" | ")
    for way, told in zip(WAYS, cells[:4], strict=True):
        assert [float(number) for number in told.split(", ")] == pytest.approx(measured(path, way), abs=0.051), way
    assert [float(number) for number in cells[4].removesuffix(" %").split(", ")] == pytest.approx(
        100.0 * over_peers(path), abs=0.51)


@pytest.mark.parametrize("path", PATHS)
def test_areas_are_those_of_the_peers_or_of_three_dimensions(path):
    """Within 15 % of the mean of both peers; where they contradict each other, of our own MPM on two grids."""
    apart = np.abs(over_peers(path)) > 0.15
    if apart.any():
        own = measured(path, "volumes")[apart]
        for cell in (3.0, 2.0):
            assert own == pytest.approx(measured(path, "MPM", cell)[apart], rel=0.15)


def test_seconds_and_errors_beside_two_peers():
    rows = {(row["program"], float(row["cell"])): row for row in figures("depth_peers_cells.csv")}
    names = {"snowmpm `depth`, volumes": "snowmpm, volumes", "snowmpm `depth`, columns": "snowmpm, columns",
             "AvaFrame com1DFA 2.1": "AvaFrame com1DFA", "MoT-Voellmy, compiled C, -O3": "MoT-Voellmy"}
    for told, program in names.items():
        shown = re.search(rf"^\| {re.escape(told)} \| (.*) \|$", GUIDE, re.MULTILINE)[1].split("|")
        ten, five, steps, finest, runout, error = (one.strip() for one in shown)
        assert [float(ten), float(five), float(finest)] == pytest.approx(
            [float(rows[program, cell]["seconds"]) for cell in (10.0, 5.0, 2.5)], abs=0.051)
        if steps:
            assert float(steps) == pytest.approx(float(rows[program, 5.0]["steps_seconds"]), abs=0.051)
        assert float(runout) == pytest.approx(float(rows[program, 5.0]["runout"]), abs=0.51)
        assert float(error.removesuffix(" %")) == pytest.approx(100.0 * float(rows[program, 5.0]["error"]), abs=0.051)
