"""`snowmpm study stability`: tables, maps and a page that is written from them."""

import pytest

from snowmpm.errors import InputError
from snowmpm.measured import borders
from snowmpm.study import open_study
from snowmpm.study.atlas.catalogue import ENTRIES
from snowmpm.study.atlas.entry import WORST, Entry


def an_entry(measure, fails="above", values=(1.0, 2.0, 4.0, 8.0)):
    return Entry(name="made_up", title="Made up", scene="", seen="", cure="", parameter="x", unit="", values=values,
                 settings={"own": {}}, symptom="y", limit=1.0, measure=measure, shown="own", fails=fails)


@pytest.mark.parametrize(("measure", "fails", "expected"), [
    (lambda x: x / 3.0, "above", 3.0), (lambda x: 3.0 / x, "below", 3.0),
    (lambda x: -x / 5.0 if x < 6.0 else float("nan"), "above", 5.0)])
def test_a_border_is_bisected(measure, fails, expected):
    entry = an_entry(measure, fails)
    found = entry.border("own", entry.row("own"))
    assert found.value == pytest.approx(expected, rel=0.02)
    assert found.failing(found.beyond(1.05)) and not found.failing(found.beyond(0.95))


def test_what_never_fails_and_what_always_does():
    good, bad = an_entry(lambda x: 0.0), an_entry(lambda x: float("inf"))
    held, lost = good.border("own", good.row("own")), bad.border("own", bad.row("own"))
    assert (held.value, held.held, held.failing(1e9)) == (None, True, False)
    assert (lost.value, lost.held, lost.failing(0.0)) == (None, False, True)
    assert bad.row("own") == [WORST] * 4


def test_the_study_writes_tables_maps_and_a_page(tmp_path):
    study = open_study("stability").study
    said = []
    paths = study(tmp_path, only=("sph_pairing",), say=said.append)
    assert {path.name for path in paths} == {"stability.csv", "stability_borders.csv", "stability.md",
                                             "stability_sums_of_SPH.png"}
    assert all(path.stat().st_size > 100 for path in paths) and "cubic spline: above 1." in said[0]
    found = borders.read(tmp_path / "stability_borders.csv")
    assert {setting for _, setting in found} == set(ENTRIES["sph_pairing"].settings)
    # Another entry joins what is there; the same again gives the same
    before = (tmp_path / "stability.csv").read_text()
    study(tmp_path, quick=True, only=("cell_crossing",), say=said.append)
    assert (tmp_path / "stability.csv").read_text().startswith(before)
    page = (tmp_path / "stability.md").read_text()
    for words in ("2 failures", "`sph_pairing`", "`cell_crossing`", "| wendland c6 | nowhere from"):
        assert words in page


def test_an_unknown_entry_is_refused(tmp_path):
    with pytest.raises(InputError, match="must be an entry"):
        open_study("stability").study(tmp_path, only=("pairs",))
