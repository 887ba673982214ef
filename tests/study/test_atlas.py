"""The atlas of failures: each failure appears where it is said to, and does not where it is said to be cured."""

import csv
from pathlib import Path

import pytest

from snowmpm.measured.borders import SHIPPED, read
from snowmpm.schemes import SCHEMES, TRANSFERS
from snowmpm.stepping.time_step import CRITICAL
from snowmpm.study.atlas.catalogue import ENTRIES

BORDERS = read(SHIPPED)
SLOW = {"shallow_flow", "stacked_bodies", "unstable_friction"}
"""Entries whose runs take some ten seconds."""


def every(names=ENTRIES):
    return [pytest.param(ENTRIES[name], marks=[pytest.mark.slow] if name in SLOW else [], id=name) for name in names]


def around(entry, setting):
    """Values of the map next to the border of a setting: on the side that holds (None where nothing does), and on the
    one that fails."""
    border = BORDERS[entry.name, setting]
    holding = [value for value in entry.values if not border.failing(value)]
    failing = [value for value in entry.values if border.failing(value)]
    above = entry.fails == "above"
    return (max(holding) if above else min(holding)) if holding else None, min(failing) if above else max(failing)


def test_there_are_entries_enough_and_each_is_measured():
    assert len(ENTRIES) >= 20
    assert set(BORDERS) == {(name, setting) for name, entry in ENTRIES.items() for setting in entry.settings}
    for (name, _), border in BORDERS.items():
        entry = ENTRIES[name]
        assert (border.title, border.parameter, border.unit, border.cure, border.fails) == (
            entry.title, entry.parameter, entry.unit, entry.cure, entry.fails)
        assert (border.lowest, border.highest) == (entry.values[0], entry.values[-1])


def test_every_entry_is_on_the_page_and_in_its_table():
    figures = Path(__file__).parents[1] / "benchmarks" / "figures"
    page = (figures / "stability.md").read_text(encoding="utf-8")
    with open(figures / "stability.csv", encoding="utf-8", newline="") as file:
        measured = {(row["entry"], row["setting"]) for row in csv.DictReader(file)}
    assert [name for name in ENTRIES if f"(`{name}`)" not in page] == []
    assert f"{len(ENTRIES)} failures" in page and set(BORDERS) <= measured


@pytest.mark.parametrize("scheme", SCHEMES, ids="-".join)
def test_the_limit_of_the_time_step_is_the_measured_one(scheme):
    *basis, transfer = scheme
    measured = BORDERS["long_step_lone_grain", " ".join(scheme)].value
    assert measured == pytest.approx(CRITICAL[tuple(basis)].of(TRANSFERS[transfer]), rel=0.03)


@pytest.mark.parametrize("entry", every())
def test_a_failure_appears_where_it_is_said_to(entry):
    holds, fails = around(entry, entry.shown)
    assert entry.fails_at(fails, entry.shown)
    assert holds is None or not entry.fails_at(holds, entry.shown)


@pytest.mark.parametrize("entry", every(name for name, entry in ENTRIES.items() if entry.cured))
def test_a_cured_failure_does_not(entry):
    _, fails = around(entry, entry.shown)
    assert not BORDERS[entry.name, entry.cured].failing(fails)
    assert not entry.fails_at(fails, entry.cured)


@pytest.mark.slow
@pytest.mark.parametrize(("name", "setting"), [key for key, border in BORDERS.items() if border.value is not None])
def test_every_border_lies_where_it_was_measured(name, setting):
    entry, border = ENTRIES[name], BORDERS[name, setting]
    assert not entry.fails_at(border.value, setting)
    beyond = border.beyond(1.0 + 2.0 * entry.resolution)
    assert entry.fails_at(min(beyond, border.highest) if entry.fails == "above" else beyond, setting)
