"""What docs/speed.md shows of other programs is what `tests/benchmarks/peers.py` wrote."""

import csv

import pytest

from tests.support.project import ROOT

FIGURES = ROOT / "tests" / "benchmarks" / "figures"
PAGE = (ROOT / "docs" / "speed.md").read_text(encoding="utf-8")


def table(name):
    with (FIGURES / name).open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def lines(head):
    """Cells of each line of the page's table that begins with `head`."""
    text = PAGE[PAGE.index(head):].split("\n\n")[0].splitlines()[2:]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in text]


def test_the_bar():
    rows = {(row["program"], row["choice"], row["dimension"], row["cells"]): row for row in table("peers.csv")}
    shown = lines("| program, scheme |")
    assert len(shown) == 9
    for name, *cells in shown:
        program, choice = name.split(": ")
        for dim, found in zip("23", (cells[:2], cells[2:]), strict=True):
            row = rows.get((program, choice, dim, "20" if program.startswith("Newton") else "40"))
            assert found == ([row["error"], row["seconds"]] if row else ["", ""]), (name, dim)


def test_the_slice_of_sand():
    rows = {(row["program"], row["choice"], row["cells"]): row for row in table("peers_sand.csv")}
    programs = [("snowmpm", "as it chooses"), ("snowmpm", "0.95 AFLIP"), ("matter", "0.95 AFLIP")]
    for count, *cells in lines("| cells | snowmpm, as it chooses"):
        for i, program in enumerate(programs):
            row = rows.get((*program, count), {"seconds": "", "middle": "", "front": ""})
            assert cells[3 * i : 3 * i + 3] == [row["seconds"], row["middle"], row["front"]], (count, program)


@pytest.mark.parametrize("program", ["matter", "GeoTaichi"])
def test_in_three_dimensions_the_same_error_takes_a_tenth_of_the_time(program):
    """Recorded figures of one run: the best of the other program on its finest grid, and ours that errs no more."""
    rows = [row for row in table("peers.csv") if row["dimension"] == "3"]
    other = min((row for row in rows if row["program"] == program and row["cells"] == "40"),
                key=lambda row: float(row["seconds"]) * float(row["error"]))
    ours = min(float(row["seconds"]) for row in rows if row["program"] == "snowmpm"
               and float(row["error"]) <= 1.1 * float(other["error"]))
    assert ours <= 0.11 * float(other["seconds"])
