"""Conclusions from the table of the accuracy-speed study, as text generated from its numbers."""

from collections import Counter

import numpy as np

from snowmpm.compiler import runtime
from snowmpm.running.device import device_name
from snowmpm.study.pareto import Refinement, front, merged, noise, time_to
from snowmpm.study.problem import KINDS
from snowmpm.study.problems.catalogue import CATALOGUE
from snowmpm.study.variation import BY_NAME, DEFAULT

CAUSES = (("3 per axis", "quadrature: the particles integrate the forces over a cell, with two an axis to so much"),
          ("float64", "round-off of float32, or noise that grows from it"), ("C = 0.2", "the time step"))
"""Variations that would lift a floor, and what it then is."""
LIFTED = 1.5
"""Times by which the error at the floor falls when its cause is taken away."""
SAME_STEP = 0.01
"""Share by which the C of a row may differ from that of its variation."""
WORTH_IT = 0.9
"""Share of the program's work below which another choice is named."""


def page(rows):
    """Markdown page of a table of `Measurement`s."""
    best = merged(rows)
    times, errors = noise(rows)
    problems = [problem for problem in CATALOGUE.values() if any(row.problem == problem.name for row in best)]
    lines = ["# Accuracy against speed", "",
             f"Written by `snowmpm study accuracy-speed` from accuracy_speed.csv: {len(best)} solutions of"
             f" {len(problems)} problems with known answers. \"program\" is what a scene gets that says nothing:"
             " quadratic splines, APIC, gradient by moving least squares, float32, two particles per cell and axis."
             " Every other line changes one thing.", "", *_other_steps(best),
             f"Times are processor seconds of the steps on {_machine()}, without compilation and output."
             f" Repeated, the same computation takes times that differ by {times:.0%} at most, and its errors by"
             f" {errors:.1%}: smaller differences of time mean nothing.", "", *_overall(best, problems)]
    for problem in problems:
        lines += ["", *_section(problem, [row for row in best if row.problem == problem.name])]
    return "\n".join(lines) + "\n"


def _other_steps(rows):
    """Which rows were measured with another C than their variation takes now."""
    now = {}
    for row in rows:
        scheme, law = BY_NAME[row.variation], CATALOGUE[row.problem].law
        now[row.key] = scheme.solved(law, row.dimension).courant(law, row.dimension)
    other = {}
    for row in rows:
        if abs(row.cfl / now[row.key] - 1.0) > SAME_STEP:
            other.setdefault(row.variation, []).append(row.cfl / now[row.key])
    if not other:
        return []
    named = ", ".join(f"{name} ({_range(shares)})" for name, shares in other.items())
    return [f"Measured with other steps than are taken now, so many times as long: {named}. A full run of the study"
            " replaces them.", ""]


def _range(values):
    least, most = min(values), max(values)
    return f"{least:.2g}" if most < 1.01 * least else f"{least:.2g} to {most:.2g}"


def _machine():
    return device_name(runtime.backend(), runtime.threads())


def _overall(rows, problems):
    """What every variation needs for the program's own error, over all problems; who is on the fronts."""
    work, time, on_front = {}, {}, Counter()
    for problem in problems:
        own = [row for row in rows if row.problem == problem.name]
        on_front.update({row.variation for row in front(own, "work")})
        for cost, ratios in (("work", work), ("seconds", time)):
            for name, ratio in equal_error(problem, own, cost).items():
                ratios.setdefault(name, {})[problem.title] = ratio
    lines = ["## All problems", "",
             "What it takes to make the error that the program makes on its usual grid, over what the program takes:"
             " work, the particle-steps at the measured cost of their scheme, which no noise disturbs, and time (median"
             " and range of the problems where both reach it); and how often a choice is on the Pareto front of error"
             " and work of a problem:", "",
             "| choice | work to the same error | time to it | reached in | on the front of |",
             "|---|---|---|---|---|"]
    for name in BY_NAME:
        if name in work:
            reached = int(np.isfinite(list(work[name].values())).sum())
            lines.append(f"| {name} | {_ratios(work[name])} | {_ratios(time[name])} | {reached} of {len(work[name])} |"
                         f" {on_front[name]} |")
    return [*lines, "", *_verdict(work, on_front, len(problems)), "", *_step(rows, problems, work)]


def _ratios(values):
    reached = np.array([value for value in values.values() if np.isfinite(value)])
    if not len(reached):
        return "not reached"
    return f"{np.median(reached):.2g}" + (f" ({reached.min():.2g} to {reached.max():.2g})" if len(reached) > 1 else "")


def _verdict(ratios, on_front, n_problems):
    """Whether the program's own choice is the Pareto choice, and what is better where."""
    said = [f"The program's own choice is on the front of {on_front[DEFAULT.name]} of {n_problems} problems."]
    better = {}
    for name, values in ratios.items():
        reached = {title: value for title, value in values.items() if np.isfinite(value)}
        if name != DEFAULT.name and len(reached) > n_problems // 2 and np.median(list(reached.values())) < WORTH_IT:
            better[name] = reached
    for name, reached in sorted(better.items(), key=lambda item: np.median(list(item[1].values()))):
        found = list(reached.values())
        said.append(f'"{name}" makes the same error with {np.median(found):.2g} of its work (median of'
                    f" {len(found)} problems, {min(found):.2g} to {max(found):.2g}){_except(ratios[name])}.")
    if not better:
        said.append(f"Nothing else makes the same error with less than {WORTH_IT:g} of its work on most"
                    " problems.")
    return [" ".join(said)]


def _except(values):
    """Problems in which a choice takes more than the program, or never gets there."""
    worse = [f"{title} ({value:.2g})" if np.isfinite(value) else f"{title} (not reached)"
             for title, value in values.items() if not value < 1.0]
    return f", but not in: {', '.join(worse)}" if worse else ""


STEPS = ("C = 0.2", "C = 0.4", "C = 0.56", DEFAULT.name)


def _step(rows, problems, work):
    """What the time step changes, by the kind of problem: error on the usual grid over that of the program's step, and
    work to the same error."""
    lines = ["### The time step", "", "Error on the usual grid over that of the program's step, by kind of problem"
             " (median, range), and work to the program's error over the program's:", "",
             f"| kind | problems | {' | '.join(f'{name}: error | work' for name in STEPS if name != DEFAULT.name)} |",
             "|---|---|" + "---|---|" * (len(STEPS) - 1)]
    for kind in KINDS:
        own = [problem for problem in problems if problem.kind == kind]
        if not own:
            continue
        cells = []
        for name in STEPS:
            if name != DEFAULT.name:
                errors = {problem.title: ratio for problem in own
                          if np.isfinite(ratio := usual_error(problem, rows, name))}
                known = {title: work[name][title] for title in errors if title in work.get(name, {})}
                cells += [_ratios(errors), _ratios(known)]
        lines.append(f"| {kind} | {len(own)} | {' | '.join(cells)} |")
    return lines


def usual_error(problem, rows, name):
    """Error of a variation on the usual grid of a problem over that of the program; nan where one is missing."""
    at = {row.variation: row.error for row in rows if row.problem == problem.name and row.cells == problem.usual}
    return at[name] / at[DEFAULT.name] if name in at and DEFAULT.name in at else float("nan")


def equal_error(problem, rows, cost="seconds"):
    """{variation: cost of the error of the program on its usual grid, over the program's}; nan: not reached."""
    usual = [row for row in rows if row.variation == DEFAULT.name and row.cells == problem.usual]
    if not usual:
        return {}
    found = {}
    for name in BY_NAME:
        line = [row for row in rows if row.variation == name]
        if line and "dim" not in BY_NAME[name].options:
            found[name] = _reach(line, usual[0].error, cost)
    return {name: value / found[DEFAULT.name] for name, value in found.items()}


def _reach(line, error, cost):
    cheapest = min(line, key=lambda row: row[cost])
    # What is better on its coarsest grid already needs no more than that
    return cheapest[cost] if cheapest.error <= error else time_to(line, error, cost)


def _section(problem, rows):
    lines = [f"## {problem.title}", "", f"Error: {problem.what}; cells: along {problem.along}.", "",
             "| choice | cells | error | seconds | order | between | floor from |", "|---|---|---|---|---|---|---|"]
    refinements = {}
    for name in BY_NAME:
        line = sorted((row for row in rows if row.variation == name), key=lambda row: row.cells)
        if not line:
            continue
        at = next((row for row in line if row.cells == problem.usual), line[-1])
        cells = [f"{name} | {at.cells} | {at.error:.2e} | {at.seconds:.2g}"]
        if len(line) > 1:
            found = refinements[name] = Refinement.of(line)
            cells.append(f"{found.order:.2f} | {found.range[0]} to {found.range[1]} | {found.floor or 'none seen'}")
        else:
            cells.append("| | ")
        lines.append(f"| {' | '.join(cells)} |")
    best = ", ".join(f"{row.variation} at {row.cells}" for row in front(rows, "work"))
    lines += ["", f"On the front, cheap to dear: {best}."]
    if DEFAULT.name in refinements:
        lines += ["", *_on_order(problem, refinements[DEFAULT.name]), *_on_floor(refinements[DEFAULT.name], rows)]
    return lines


def _on_order(problem, found):
    said = f"The program's error falls with order {found.order:.2f} between {found.range[0]} and {found.range[1]} cells"
    if problem.order is None:
        return [f"{said}; no order is declared for this problem."]
    return [f"{said}; declared: {problem.order:g}."]


def _on_floor(found, rows):
    """Why the program's error falls no more: which variation lifts the floor on its finest grid."""
    if found.floor is None:
        return ["No floor is seen on these grids."]
    finest = max(row.cells for row in rows if row.variation == DEFAULT.name)
    at = {row.variation: row.error for row in rows if row.cells == finest}
    said = [f"From {found.floor} cells on it falls no more."]
    known = [(name, cause) for name, cause in CAUSES if name in at]
    for name, cause in known:
        ratio = at[DEFAULT.name] / at[name]
        if ratio > LIFTED:
            said.append(f"With \"{name}\" the error at {finest} cells is {ratio:.2g} times less: {cause}.")
        else:
            said.append(f"\"{name}\" changes it by {ratio:.2g} only.")
    return [" ".join(said)]
