"""The study of models: its table, its references, its charts; the figures that ship and those in the guide."""

import re
from pathlib import Path

import numpy as np
import pytest

from snowmpm.errors import InputError, SimulationError
from snowmpm.ladder import study
from snowmpm.ladder.questions import QUESTIONS
from snowmpm.measured import models

GUIDE = Path(__file__).parents[2] / "docs" / "models.md"


@pytest.fixture
def without_runs(monkeypatch):
    """Answers of a made-up column: a run-out of 1 m less what a cell costs, in a second and more."""
    def answered(scene, asks, step):
        if step.name == "sph, 4 cells":
            raise SimulationError("broke off")
        cells = float(step.name.split()[1])
        return dict.fromkeys(asks, 1.0 - 1.0 / cells / (1 + step.name.startswith("mpm"))), cells

    monkeypatch.setattr(study, "answered", answered)


def test_a_study_writes_a_table_charts_and_a_page_and_keeps_what_was_there(tmp_path, without_runs):
    said = []
    paths = study.study(tmp_path, only=("column of sand",), say=said.append)
    assert [path.name for path in paths] == ["models.csv", "models_run-out.png", "models.md"]
    rows = {row.rung: row for row in models.read(paths[0])}
    assert "sph, 4 cells" not in rows and any("broke off" in line for line in said)
    finest = rows["mpm, 32 cells"]
    assert {row.reference for row in rows.values()} == {finest.value} and finest.error == 0.0
    assert finest.unsure == pytest.approx(1.0 - rows["mpm, 16 cells"].value / finest.value, rel=1e-4)
    study.study(tmp_path, only=("tall column of sand",), say=said.append)
    assert {row.problem for row in models.read(paths[0])} == {"column of sand", "tall column of sand"}


@pytest.fixture(scope="module")
def ratios():
    """Seconds over what was foretold, of all rungs that are runs."""
    known = {(row.problem, row.rung): row.seconds / row.forecast for row in models.shipped() if ", " in row.rung}
    return np.array(list(known.values()))


def test_forecasts_of_rungs_are_right_within_thirty_per_cent_in_the_median(ratios):
    assert len(ratios) > 180 and np.median(np.abs(ratios - 1.0)) <= 0.3


@pytest.mark.xfail(strict=True, reason="87 %: SPH on the ground takes up to three times what is foretold, and frames of"
                   " few particles half of it")
def test_nine_of_ten_forecasts_are_right_within_a_factor_of_two(ratios):
    assert np.mean((ratios > 0.5) & (ratios < 2.0)) >= 0.9


def test_an_unknown_problem_is_refused():
    with pytest.raises(InputError, match="--only"):
        study.study(Path(), only=("nonsense",))


def test_a_command_that_fails_says_why():
    with pytest.raises(SimulationError, match=r"nonsense"):
        study.spent(["run", "nonsense"])


def test_the_guide_has_every_question_with_its_definition():
    text = GUIDE.read_text(encoding="utf-8")
    for question in QUESTIONS.values():
        assert f"| `{question.name}` | {question.says} |" in text


def test_the_tables_of_the_guide_are_those_of_the_measurements():
    text, shipped = GUIDE.read_text(encoding="utf-8"), list(models.shipped())
    for name in QUESTIONS:
        if any(row.question == name for row in shipped):
            assert study.page_of(name, shipped) in text, name
    assert f"{len({row.problem for row in shipped})} problems" in text


def test_the_front_of_the_guide_never_rises():
    """Bold rows: each is better than all that are cheaper."""
    for table in re.findall(r"(?:^\|.*\n)+", GUIDE.read_text(encoding="utf-8"), re.MULTILINE):
        bold = [row for row in table.splitlines() if "**" in row and "%" in row]
        errors = [max(abs(float(number)) if number else 1e4 for number in (
            re.findall(r"([+-]?\d+)%", row) or [""])) for row in bold]
        assert errors == sorted(errors, reverse=True), table
