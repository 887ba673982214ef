"""What docs/speed.md shows of other programs is what `tests/benchmarks/peers.py` wrote."""

import csv

import pytest

from tests.benchmarks import peers
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


@pytest.mark.parametrize(("program", "choice", "ours", "least"), [
    ("matter", "0.95 AFLIP, quadratic", "0.95 AFLIP, quadratic", 9.0),
    ("matter", "APIC, quadratic", "APIC, quadratic", 12.0), ("GeoTaichi", "Taylor PIC", "APIC, quadratic", 12.0)])
def test_the_same_scheme_in_three_dimensions(program, choice, ours, least):
    """Recorded figures on the finest grid: errors within 8 %, and what the page says of the times."""
    rows = {(row["program"], row["choice"]): row for row in table("peers.csv")
            if (row["dimension"], row["cells"]) == ("3", "40")}
    other, own = rows[program, choice], rows["snowmpm", ours]
    assert float(own["error"]) == pytest.approx(float(other["error"]), rel=0.08)
    assert least < float(other["seconds"]) / float(own["seconds"]) < 13.5


def test_a_picture_of_the_tables_that_are_there(tmp_path):
    """Of a run without the second problem, or without its finest grid; none of an empty folder."""
    peers.draw(tmp_path)
    assert not (tmp_path / "peers.png").exists()
    (tmp_path / "peers.csv").write_bytes((FIGURES / "peers.csv").read_bytes())
    peers.draw(tmp_path)
    assert (tmp_path / "peers.png").stat().st_size > 10_000


@pytest.mark.parametrize("words", [("--matter", "nowhere"), ("--newton", "nowhere/python")])
def test_a_peer_that_is_not_there(words, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr("sys.argv", ["peers.py", *words, "-o", str(tmp_path / "out")])
    with pytest.raises(SystemExit):
        peers.main()
    assert "no such file or folder" in capsys.readouterr().err and not (tmp_path / "out").exists()
