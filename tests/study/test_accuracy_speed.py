"""The accuracy-speed study: its committed table agrees with the declared orders; its page says what stands in it."""

from pathlib import Path

import numpy as np
import pytest

from snowmpm.errors import InputError
from snowmpm.study import STUDIES, accuracy_speed, conclusions, open_study
from snowmpm.study.measurement import read
from snowmpm.study.pareto import Refinement, front, merged
from snowmpm.study.problem import KINDS
from snowmpm.study.problems.catalogue import CATALOGUE
from snowmpm.study.variation import BY_NAME

TABLE = Path(accuracy_speed.__file__).with_name("data") / accuracy_speed.TABLE


@pytest.fixture(scope="module")
def rows():
    return merged(read(TABLE))


def line(rows, problem, variation):
    return sorted((row for row in rows if (row.problem, row.variation) == (problem, variation)),
                  key=lambda row: row.cells)


@pytest.mark.parametrize("variation", ["C = 0.4", "float64", "shape", "3 per axis", "cubic", "cubic, 3 per axis"])
@pytest.mark.parametrize("problem", [name for name, problem in CATALOGUE.items() if problem.order])
def test_slopes_agree_with_the_declared_order(rows, problem, variation):
    """Second order, from the grid that resolves the problem to the floor. On the coarsest grid errors fall faster:
    8 cells to a wave or a ring of half a metre are hardly a resolution; never slower than the order by more than what
    the floor, which adds to the error of the last grid, takes off. In steps of C = 0.4: longer ones take from the error
    of the coarsest grid."""
    found = Refinement.of(line(rows, problem, variation))
    assert CATALOGUE[problem].order - 0.5 < found.order < CATALOGUE[problem].order + 0.8
    assert found.range[1] / found.range[0] >= 2


def test_the_floor_is_of_quadrature(rows):
    """M6: with two particles an axis the error stops to fall; three lower it, cubic splines hardly feel it, and neither
    float64 nor shorter steps move it."""
    assert Refinement.of(line(rows, "waves", "program")).floor is not None
    finest = {name: line(rows, "waves", name)[-1].error for name in (
        "program", "3 per axis", "cubic", "float64", "C = 0.2")}
    assert finest["program"] > 2.0 * finest["3 per axis"] and finest["program"] > 4.0 * finest["cubic"]
    assert finest["float64"] == pytest.approx(finest["program"], rel=0.1)
    assert finest["C = 0.2"] == pytest.approx(finest["program"], rel=0.1)


def test_the_program_is_on_the_front_of_every_problem(rows):
    """Of error against particle-steps, which no noise disturbs."""
    for problem in CATALOGUE.values():
        best = front([row for row in rows if row.problem == problem.name], "particle_steps")
        assert "program" in {row.variation for row in best}, problem.name


def test_shorter_steps_pay_only_where_bonds_break(rows):
    """Why the step follows the state: with C = 0.4 throughout the same error takes half as much work again, or more, in
    elastic, granular and impact problems; in a crack of a weak layer the error grows with the step."""
    work = {kind: {} for kind in KINDS}
    for problem in CATALOGUE.values():
        own = [row for row in rows if row.problem == problem.name]
        for name, ratio in conclusions.equal_error(problem, own, "particle_steps").items():
            work[problem.kind].setdefault(name, []).append(ratio)
    for kind in ("elastic", "granular", "impact"):
        assert np.nanmedian(work[kind]["C = 0.4"]) > 1.5
        assert all(not ratio < 2.5 for ratio in work[kind]["C = 0.2"])  # nan: never as good
    errors = {name: line(rows, "anticrack", name)[-1].error for name in ("program", "C = 0.2", "C = 0.4", "C = 0.56")}
    assert errors["C = 0.2"] < 0.8 * errors["C = 0.4"] and errors["C = 0.4"] < 0.9 * errors["C = 0.56"]
    assert errors["program"] < 1.1 * errors["C = 0.4"]


def test_every_problem_and_choice_is_in_the_table(rows):
    assert {row.problem for row in rows} == set(CATALOGUE)
    for problem in CATALOGUE.values():
        wanted = {variation.name for variation in BY_NAME.values() if problem.takes(variation)}
        assert wanted <= {row.variation for row in rows if row.problem == problem.name}


def test_conclusions_come_from_the_table(rows):
    page = conclusions.page(rows)
    for problem in CATALOGUE.values():
        assert problem.title in page
    usual = next(row for row in line(rows, "bar", "program") if row.cells == CATALOGUE["bar"].usual)
    assert f"| program | {usual.cells} | {usual.error:.2e} |" in page
    assert "quadrature" in page
    worse = [row for row in rows if row.problem == "bar"]
    assert conclusions.page(worse) != page and "(M6)" not in conclusions.page(worse)


def test_a_short_study_writes_its_files_and_keeps_what_was_there(tmp_path):
    said = []
    paths = accuracy_speed.study(tmp_path, quick=True, only=("vortex", "program"), say=said.append)
    assert [path.name for path in paths] == ["accuracy_speed.csv", "accuracy_speed.png", "accuracy_work.png",
                                            "accuracy_grid.png", "accuracy_speed.md"]
    assert all(path.stat().st_size > 500 for path in paths)
    measured = read(paths[0])
    assert len(said) == len(CATALOGUE["vortex"].quick)
    assert {(row.problem, row.variation) for row in measured} == {("vortex", "program")}
    committed = {row.cells: row.error for row in line(merged(read(TABLE)), "vortex", "program")}
    for row in measured:
        assert np.isclose(row.error, committed[row.cells], rtol=0.02)  # f32: other machines round otherwise
    accuracy_speed.study(tmp_path, quick=True, only=("vortex", "PIC"), say=said.append)
    assert {row.variation for row in read(paths[0])} == {"program", "PIC"}


def test_what_is_unknown_is_refused():
    with pytest.raises(InputError, match=r"--only.*nonsense"):
        accuracy_speed.chosen(("nonsense",), quick=True)
    with pytest.raises(InputError, match="accuracy-speed"):
        open_study("nonsense")


def test_every_study_can_be_opened():
    for name in STUDIES:
        module = open_study(name)
        assert callable(module.study) and module.__doc__
