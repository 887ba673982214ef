"""Each scene of the library says what it tells and how well, and stands on the coarsest cells that keep to that.

The figures are those of tests/benchmarks/figures/library_answers.csv: the answer on the cells of the scene, on cells
twice as wide, and on finer ones.
"""

import csv
import re

import pytest

from snowmpm.scenes.library import library
from snowmpm.scenes.loader import find_scene
from tests.benchmarks.library_answers import FILE, TOLD, rows_of

TELLS = re.compile(r"^# Answer: (.+?)(?:, within (\d+) % of (?:that on finer cells|the law of the experiments))?"
                   r"(?:; on cells twice as wide it is (\d+) % off)?\.$", re.MULTILINE)
DEARER = 2.0
"""Ratio of times from which on wider cells are worth something."""
YES_NO = "whether the slab releases"
STORIES = {"slab_release": "crown, flanks and blocks, for which cells twice as wide have less than two over the slab",
           "slab_release_resolved": "a weak layer of two cells"}
"""Scenes that show more than their answer, and what."""


def table():
    with FILE.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    return {name: {row["grid"]: row for row in rows if row["scene"] == name} for name in TOLD}


def said(name):
    """(answer, tolerance, what wider cells are off, both [-] or None) of a scene's header."""
    found = TELLS.findall(find_scene(name).read_text(encoding="utf-8"))
    assert len(found) == 1, f"{name}: one line «# Answer: ..., within N % of that on finer cells.»"
    answer, *shares = found[0]
    return answer, *(float(share) / 100.0 if share else None for share in shares)


def test_each_scene_is_in_the_table():
    assert sorted(TOLD) == sorted(library()) == sorted(name for name, rows in table().items() if rows)


@pytest.mark.parametrize("name", sorted(TOLD))
def test_a_scene_keeps_what_its_header_says(name):
    answer, within, off = said(name)
    rows = table()[name]
    own = rows["own"]
    assert answer == TOLD[name].answer == own["answer"]
    if answer == YES_NO:
        assert within is None and own["value"] in "01"
        return
    finer = rows.get("finer") or rows.get("law")
    if finer is not None:
        assert abs(float(own["value"]) / float(finer["value"]) - 1.0) <= within
        return
    assert within is None  # finer cells are too dear: what wider cells tell is all that is known
    if not rows["wider"]["why"]:
        assert abs(float(rows["wider"]["value"]) / float(own["value"]) - 1.0) == pytest.approx(off, abs=0.006)


@pytest.mark.parametrize("name", sorted(TOLD))
def test_wider_cells_would_not_do_or_save_little(name):
    answer, within, _ = said(name)
    rows = table()[name]
    own, wider, finer = rows["own"], rows["wider"], rows.get("finer") or rows.get("law")
    if name in STORIES or wider["why"] or float(own["seconds"]) < DEARER * float(wider["seconds"]):
        return
    if answer == YES_NO:
        assert wider["value"] != own["value"]
        return
    best = finer or own
    assert abs(float(wider["value"]) / float(best["value"]) - 1.0) > (within or 0.1)


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(TOLD))
def test_the_table_is_what_the_scene_tells(name):
    """On the cells of the scene, to the figures of the table: to 2 %, as another processor may round otherwise."""
    row = next(rows_of(name, grids=("own",)))
    assert not row["why"]
    assert float(row["value"]) == pytest.approx(float(table()[name]["own"]["value"]), rel=0.02)
