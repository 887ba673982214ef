"""What docs/speed.md shows of several cards is what `tests/benchmarks/halo.py --cards` works out."""

import csv

from tests.benchmarks import halo
from tests.support.project import ROOT


def test_the_page_shows_the_table():
    page = (ROOT / "docs" / "speed.md").read_text(encoding="utf-8")
    with halo.CARDS.open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == sum(len(cards) for _, cards in halo.SIZES)
    for row in rows:
        value = {name: float(row[name]) for name in row}
        line = (f"| {row['particles']} | {row['cards']} | {1e3 * value['kernels']:.3g} ms |"
                f" {1e3 * value['sort']:.3g} ms | {1e-6 * value['sent']:.3g} MB |"
                f" {100 * value['nvlink']:.2g} % | {100 * value['pcie']:.2g} % |"
                f" {100 * value['infiniband']:.2g} % | {row['faster']} | {row['most']} |")
        assert line in page


def test_the_table_is_what_the_command_works_out(tmp_path, capsys):
    halo.write(halo.rows_of_cards(), tmp_path / "cards.csv")
    assert (tmp_path / "cards.csv").read_text(encoding="utf-8") == halo.CARDS.read_text(encoding="utf-8")
    assert capsys.readouterr().out.count("\n") == len(list(halo.rows_of_cards()))
