"""Order of convergence of every scheme in the problems that declare one: error against the grid, coarse to fine.

Table of errors and of the order between neighbouring grids, chart with the declared order as a dashed line, and a page
that compares measured and declared order.
"""

from pathlib import Path

from snowmpm.draft import write_text
from snowmpm.stages import counted
from snowmpm.study.accuracy_speed import chart, chosen, refined
from snowmpm.study.measurement import read, write
from snowmpm.study.pareto import Refinement, merged, orders
from snowmpm.study.variation import BY_NAME

TABLE = "convergence.csv"
SCHEMES = ("program", "float64", "cubic", "shape", "cubic, shape", "PIC", "FLIP 0.99", "AFLIP 0.99", "3 per axis",
           "cubic, 3 per axis")


def study(folder, *, quick=False, only=(), say=print):
    """Measure, draw, compare with the declared order; -> paths. only: names of problems or variations."""
    problems, variations = chosen(only, quick)
    names = SCHEMES if not any(name in BY_NAME for name in only) else [variation.name for variation in variations]
    path, rows = Path(folder) / TABLE, []
    pairs = [(problem, BY_NAME[name]) for problem in problems for name in names
             if problem.order and problem.takes(BY_NAME[name])]
    for problem, variation in counted(pairs, "convergence", "cases"):
        rows += refined(problem, variation, quick, say)
        write(rows, path)
    page = write_text(Path(folder) / "convergence.md", "\n".join(report(problems, merged(read(path)))) + "\n")
    return [path, chart(merged(rows), Path(folder) / "convergence.png", "cells", "cells"), page]


def report(problems, rows):
    """Markdown lines: orders between the grids, and over what falls."""
    lines = ["# Order of convergence", ""]
    for problem in problems:
        own = [row for row in rows if row.problem == problem.name]
        if not own:
            continue
        lines += [f"## {problem.title}", "", f"Error: {problem.what}. Declared order: {problem.order:g}.", "",
                  "| scheme | order between grids | over the range | floor from |", "|---|---|---|---|"]
        for name in dict.fromkeys(row.variation for row in own):
            line = sorted((row for row in own if row.variation == name), key=lambda row: row.cells)
            between = ", ".join(f"{order:.2f}" for *_, order in orders(line))
            found = Refinement.of(line)
            lines.append(f"| {name} | {between} | {found.order:.2f}, {found.range[0]} to {found.range[1]} cells |"
                         f" {found.floor or 'none seen'} |")
        lines.append("")
    return lines
