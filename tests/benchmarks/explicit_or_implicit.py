"""Explicit against implicit MPM: error against processor seconds, and against the step, in five cases (I9).

    python tests/benchmarks/explicit_or_implicit.py [--cases column beam ...] [--again] [-o FOLDER]

Measures what the table lacks of the cases, or all of them (--again). Writes a row to the table that ships with the
program (`snowmpm.measured.explicit_or_implicit`) as soon as it is there, and draws explicit_or_implicit.png. One
thread; each case takes its first way of both kinds once before, so that kernels are compiled.
"""

import argparse
import csv
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from snowmpm.measured.explicit_or_implicit import TABLE
from tests.support.explicit_or_implicit import CASES, Way

COLUMNS = ("case", "method", "cells", "step", "error", "seconds", "steps", "dt")


def table(path):
    """Rows of the file that is there."""
    if not path.exists():
        return []
    with open(path, newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def as_way(row):
    """`Way` of a row of the table."""
    return Way(row["method"] == "implicit", int(row["cells"]), float(row["step"]))


def write(rows, path):
    with open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, COLUMNS)
        writer.writeheader()
        writer.writerows(rows)


def chart(rows, path):
    """Error against seconds above, against the step below."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(13.0, 5.6), layout="constrained")
    panels = figure.subplots(2, len(CASES), sharey="col", squeeze=False)
    for column, case in enumerate(CASES):
        for row, (key, words) in enumerate((("seconds", "processor time [s]"), ("dt", "step [s]"))):
            panel = panels[row, column]
            for method, marker in (("explicit", "o"), ("implicit", "s")):
                found = [one for one in rows if one["case"] == case.__name__ and one["method"] == method]
                panel.loglog([float(one[key]) for one in found], [float(one["error"]) for one in found], marker,
                             label=method)
            for axis, values in (("x", panel.get_xlim()), ("y", panel.get_ylim())):  # whole decades
                lower, upper = 10.0 ** np.floor(np.log10(values[0])), 10.0 ** np.ceil(np.log10(values[1]))
                panel.set(**{f"{axis}lim": (lower, upper)})
            panel.set_xlabel(words)
            panel.grid(alpha=0.3)
        panels[0, column].set_title(case.__name__.replace("_", " "))
    panels[0, 0].set_ylabel("error [-]")
    panels[1, 0].set_ylabel("error [-]")
    panels[0, 0].legend()
    figure.savefig(path, dpi=110)


def main():
    from snowmpm.compiler import runtime

    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    names = {case.__name__: case for case in CASES}
    parser.add_argument("--cases", nargs="+", choices=names, default=list(names))
    parser.add_argument("--again", action="store_true")
    parser.add_argument("-o", "--output", type=Path, default=Path(__file__).parent / "figures")
    options = parser.parse_args()
    runtime.start("cpu", threads=1)
    rows = table(TABLE)
    for name in options.cases:
        case = names[name]
        rows = [row for row in rows if row["case"] != name or (not options.again and as_way(row) in CASES[case])]
        left = [way for way in CASES[case] if way not in [as_way(row) for row in rows if row["case"] == name]]
        for way in left[:1] + [way for way in left if way.implicit][:1]:
            case(way)
        for way in left:
            found = case(way)
            rows.append({"case": name, "method": "implicit" if way.implicit else "explicit", "cells": way.cells,
                         "step": f"{way.step:g}", "error": f"{found.error:.3g}", "seconds": f"{found.seconds:.3g}",
                         "steps": found.steps, "dt": f"{found.dt:.3g}"})
            print(rows[-1], flush=True)
            write(rows, TABLE)
    write(rows, TABLE)
    chart(rows, options.output / "explicit_or_implicit.png")


if __name__ == "__main__":
    main()
