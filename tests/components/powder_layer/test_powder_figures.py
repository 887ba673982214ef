"""The sensitivities that the guide tells are those of the table that the benchmark wrote."""

import csv
import re

import pytest

from tests.support.project import ROOT

GUIDE = (ROOT / "docs" / "powder_layer.md").read_text(encoding="utf-8")
ROWS = {"air_entrainment = \"parker_1987\"": ["air_entrainment = parker_1987"],
        "suspension_rate": ["suspension_rate x 1/2", "suspension_rate x 2"],
        "suspension = \"shear_excess\"": ["suspension = shear_excess"],
        "grain_diameter": ["grain_diameter = 0.1 mm", "grain_diameter = 0.5 mm"],
        "bed_concentration = \"uniform\"": ["bed_concentration = uniform"],
        "ground_drag": ["ground_drag x 1/2", "ground_drag x 2"],
        "front_drag": ["front_drag = 0", "front_drag x 2"],
        "profile = \"motpsa\"": ["profile = motpsa"],
        "cells of": ["cells of 10 m", "cells of 2.5 m"]}
"""How a line of the guide begins, and the rows of the table that it tells."""


@pytest.fixture(scope="module")
def table():
    with (ROOT / "tests" / "benchmarks" / "figures" / "powder_layer.csv").open(newline="", encoding="utf-8") as file:
        return {row["variant"]: {name: float(value) for name, value in row.items() if name != "variant"}
                for row in csv.DictReader(file)}


def numbers(text):
    return [float(number) for number in re.findall(r"\d+(?:\.\d+)?", text)]


@pytest.mark.parametrize("start", ROWS)
def test_a_line_of_the_guide(start, table):
    """To the last digit told; a reach of 0 is called nowhere."""
    line = re.search(rf"^\| `?{re.escape(start)}.*\|$", GUIDE, re.MULTILINE)[0]
    _, _, pressure, reach, _ = line.split("|")
    rows = [table[name] for name in ROWS[start]]
    column = [row["pressure_kpa"] for row in rows]
    if start.startswith("profile"):
        column.append(rows[0]["foot_pressure_kpa"])
    assert numbers(pressure) == pytest.approx(column, abs=0.051)
    assert (numbers(reach) or [0.0]) == pytest.approx([row["reach_1_kpa"] for row in rows], abs=0.51)


def test_what_the_guide_says_of_all(table):
    usual = table["usual"]
    told = re.search(r"largest mean pressure (.*) kPa, and 1 kPa as far as (\d+) m, where the flow itself comes to"
                     r" (\d+) m", GUIDE)
    assert [float(one) for one in told.groups()] == pytest.approx(
        [usual[name] for name in ("pressure_kpa", "reach_1_kpa", "flow_reach")], abs=0.51)
    short = usual["flow_reach"] - usual["reach_1_kpa"]
    ends = re.search(r"1 kPa of the cloud ends (\d+) m before the flow", GUIDE)[1]
    assert float(ends) == pytest.approx(short, abs=0.51)
    pressures = [row["pressure_kpa"] for name, row in table.items() if "none" not in name]
    assert max(pressures) / min(pressures) == pytest.approx(
        float(re.search(r"open by a factor of (\d+)", GUIDE)[1]), abs=0.6)
    finer = table["cells of 2.5 m"]["pressure_kpa"] / table["cells of 10 m"]["pressure_kpa"]
    assert finer == pytest.approx(float(re.search(r"by (\d\.\d) with the cells", GUIDE)[1]), abs=0.051)


def test_the_picture_is_small():
    assert (ROOT / "docs" / "figures" / "powder_layer.png").stat().st_size < 100_000
