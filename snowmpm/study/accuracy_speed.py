"""Error against time of every choice of the solver, in problems whose answer is known.

Each problem is solved as the program would by itself, and again with one choice changed (`variation.VARIATIONS`), on
grids from coarse to fine. Table, two work-precision charts (error against processor seconds and against
particle-steps), the same errors against the grid, and a page of conclusions that is written from the table.
"""

from pathlib import Path

import numpy as np

from snowmpm.draft import write_text
from snowmpm.errors import InputError, SimulationError
from snowmpm.render.work_precision_plot import Curve, Panel, render_work_precision
from snowmpm.stages import counted
from snowmpm.study import conclusions
from snowmpm.study.measurement import measure, read, write
from snowmpm.study.pareto import front, merged
from snowmpm.study.problems.catalogue import CATALOGUE
from snowmpm.study.variation import BY_NAME, DEFAULT, QUICK, VARIATIONS

TABLE = "accuracy_speed.csv"
REPEATS = 3
"""Of the program's own choice on the usual grid: what the times of the same computation differ by."""


def study(folder, *, quick=False, only=(), say=print):
    """Measure, draw and conclude; -> paths. only: names of problems or variations; rows that are in the folder's table
    already are kept when something is named."""
    problems, variations = chosen(only, quick)
    path = Path(folder) / TABLE
    kept = read(path) if only and path.exists() else []
    taken = {(problem.name, variation.name) for problem in problems for variation in variations}
    rows = [row for row in kept if (row.problem, row.variation) not in taken]
    pairs = [(problem, variation) for problem in problems for variation in variations if problem.takes(variation)]
    for problem, variation in counted(pairs, "accuracy against speed", "cases"):
        rows += refined(problem, variation, quick, say)
        write(rows, path)
    return [path, *report(rows, folder)]


def chosen(only, quick):
    """Problems and variations of the form, or those named. Raises InputError for a name that is neither."""
    for name in only:
        if name not in CATALOGUE and name not in BY_NAME:
            raise InputError.at("--only", name, f"must be a problem ({', '.join(CATALOGUE)}) or a variation"
                                f" ({', '.join(BY_NAME)})")
    names = [name for name in only if name in CATALOGUE] or list(CATALOGUE)
    changes = [name for name in only if name in BY_NAME] or [
        variation.name for variation in VARIATIONS if not quick or variation.name in QUICK or variation.options]
    return [CATALOGUE[name] for name in names], [BY_NAME[name] for name in changes]


def refined(problem, variation, quick, say):
    """Rows of one variation of one problem, coarse to fine; a grid that fails is said and left out."""
    rows = []
    for cells in problem.grids(variation, quick):
        own = variation == DEFAULT and cells == problem.usual
        try:
            for _ in range(REPEATS if own else 1):
                rows.append(measure(problem, variation, cells))
        except SimulationError as error:
            say(f"{problem.name}, {variation.name}, {cells} cells: failed: {str(error).splitlines()[0]}")
            continue
        if not np.isfinite(rows[-1].error):
            say(f"{problem.name}, {variation.name}, {cells} cells: no answer")
            rows = [row for row in rows if row.cells != cells]
            continue
        say(f"{problem.name:12s} {variation.name:20s} {cells:4d} cells {rows[-1].particles:8d} particles"
            f" {rows[-1].seconds:8.2f} s  error {rows[-1].error:.2e}")
    return rows


def report(rows, folder):
    """Charts and conclusions of a table of rows; -> paths."""
    folder, best = Path(folder), merged(rows)
    charts = [
        chart(best, folder / "accuracy_speed.png", "seconds", "processor seconds of all steps, one thread"),
        chart(best, folder / "accuracy_work.png", "work", "particle-steps at the measured cost of their scheme [s]"),
        chart(best, folder / "accuracy_grid.png", "cells", "cells"),
        *step_chart(best, folder / "accuracy_step.png"),
    ]
    return [*charts, write_text(folder / "accuracy_speed.md", conclusions.page(rows))]


TITLES = {"seconds": "Error against time", "work": "Error against work", "cells": "Error against the grid"}


def chart(rows, output, cost, label):
    """Error against `cost`, a panel a problem; -> path."""
    panels = []
    for problem in CATALOGUE.values():
        own = [row for row in rows if row.problem == problem.name]
        if not own:
            continue
        curves = tuple(Curve(name, variation.group, tuple(row[cost] for row in line),
                             tuple(row.error for row in line))
                       for name, variation in BY_NAME.items() if (line := _line(own, name)))
        best = None
        if cost != "cells":
            line = front(own, cost)
            best = tuple(row[cost] for row in line), tuple(row.error for row in line)
        panels.append(Panel(problem.title, curves, best, _guide(problem, curves, cost), f"error: {problem.what}"))
    return render_work_precision(panels, output, x_label=label, title=f"{TITLES[cost]}: every choice of the solver")


def step_chart(rows, output):
    """What the time step changes, against that of the program; -> paths, none without a problem of three steps."""
    errors, work = [], []
    for problem in CATALOGUE.values():
        own = [row for row in rows if row.problem == problem.name]
        at = {row.variation: row for row in own if row.cells == problem.usual}
        names = [name for name in conclusions.STEPS if name in at]
        if DEFAULT.name not in names or len(names) < 3:
            continue
        steps = [at[name].cfl / at[DEFAULT.name].cfl for name in names]
        errors.append(Curve(problem.title, problem.kind, tuple(steps),
                            tuple(conclusions.usual_error(problem, own, name) for name in names)))
        same = conclusions.equal_error(problem, own, "work")
        known = [(step, same[name]) for step, name in zip(steps, names, strict=True) if np.isfinite(same[name])]
        work.append(Curve(problem.title, problem.kind, *zip(*known, strict=True)))
    if not errors:
        return []
    panels = [Panel("error on the usual grid", tuple(errors), note="over that of the program's step"),
              Panel("work to the same error", tuple(work), note="over the program's, by refining the grid")]
    return [render_work_precision(panels, output, x_label="time step over the program's", y_label="ratio", columns=2,
                                  size=(10.5, 5.2), legend_columns=3, title="The time step: what a longer one changes")]


def _line(rows, name):
    return sorted((row for row in rows if row.variation == name), key=lambda row: row.cells)


def _guide(problem, curves, cost):
    """Slope of the problem's order: dx² in the grid, and dx² against dx^-3 of work in plane strain."""
    if problem.order is None or cost == "seconds" or curves[0].name != DEFAULT.name:
        return None
    return (-problem.order if cost == "cells" else -problem.order / 3.0), f"order {problem.order:g}"
