"""Errors and orders of every basis, gradient and transfer in the manufactured motions M6 and M7: CSV and chart.

    python tests/benchmarks/order_tables.py [-o FOLDER] [--only WORD] [--per-cell 4 9] [--resume] [--precision f64]
                                            [--threads 1]

    waves     standing waves in a periodic square (M6, A = 0.02): no rim, strains of 13 %
    vortex    the generalised vortex (M7, A = 0.1): a ring with rims that cut the cells, shears of 0.7

8 to 64 cells a metre, 4 and 9 particles per cell on a lattice. Errors of displacement and stress, root mean square and
worst particle, over the size that each case gives; order = log2 of the error of the row above over that of this row.
FLIP and AFLIP keep 0.99 a step. A step is a fixed share of dx / c, so that time and space are refined together.

The chart shows the root mean squares. `--only quadratic-apic` takes the schemes whose name holds the word; `--resume`
keeps the rows that are there.
"""

import argparse
import csv
import itertools
from dataclasses import replace
from pathlib import Path

import numpy as np

from snowmpm.compiler import runtime
from snowmpm.study.problems.generalised_vortex import vortex_errors
from snowmpm.study.problems.periodic_waves import wave_errors
from snowmpm.study.problems.schemes import EVERY

CASES = {"waves": wave_errors, "vortex": vortex_errors}
CELLS, PER_CELL = (8, 16, 32, 64), (4, 9)
SIZES = ("displacement", "largest_displacement", "stress", "largest_stress")
COLUMNS = ("case", "basis", "gradient", "transfer", "flip_ratio", "particles_per_cell", "cells_per_metre", *SIZES,
           *(f"order_{size}" for size in SIZES), "precision", "threads")


def table(case, scheme, key, precision, threads):
    """Rows of one scheme, coarse to fine; key: their first columns."""
    last = None
    for cells in CELLS:
        errors = CASES[case](replace(scheme, precision=precision), cells, per_axis=round(int(key[-1]) ** 0.5))
        found = np.array([getattr(errors, size) for size in SIZES])
        orders = [""] * len(SIZES) if last is None else [f"{order:.2f}" for order in np.log2(last / found)]
        yield (*key, str(cells), *(f"{error:.3e}" for error in found), *orders, precision, str(threads))
        last = found


def draw(rows, file):
    """Root mean squares over the cells: a panel for each case and number of particles, displacement above stress."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    colours = {"pic": "0.6", "apic": "C0", "flip": "C3", "aflip": "C2"}
    figure, axes = plt.subplots(2, 4, figsize=(15, 8), sharex=True, sharey="row", layout="constrained")
    for column, (case, per_cell) in enumerate(itertools.product(CASES, PER_CELL)):
        for line, size in enumerate(("displacement", "stress")):
            axis = axes[line, column]
            for scheme in EVERY:
                key = (case, scheme.kernel, scheme.gradient, scheme.transfer)
                chosen = [dict(zip(COLUMNS, row, strict=True)) for row in rows
                          if tuple(row[:4]) == key and int(row[5]) == per_cell]
                axis.loglog([int(row["cells_per_metre"]) for row in chosen], [float(row[size]) for row in chosen],
                            marker="o" if scheme.kernel == "quadratic" else "^", markersize=4, linewidth=1.2,
                            linestyle="-" if scheme.gradient == "affine" else ":", color=colours[scheme.transfer],
                            markerfacecolor="none" if scheme.gradient == "shape" else None)
            axis.set_xticks(CELLS, [str(n) for n in CELLS])
            axis.minorticks_off()
            axis.grid(True, which="major", alpha=0.3)
        axes[0, column].set_title(f"{case}, {per_cell} particles per cell")
        axes[1, column].set_xlabel("cells per metre")
    for line, size in enumerate(("displacement", "stress")):
        axes[line, 0].set_ylabel(f"error of the {size}")
        for axis in axes[line]:
            anchor = 0.02 if line == 0 else 0.05
            axis.plot(CELLS, [anchor * (8 / n) ** 2 for n in CELLS], color="black", linewidth=0.8, linestyle="--")
    for name, style in ({transfer: {"color": colour} for transfer, colour in colours.items()} | {
            "quadratic": {"color": "black", "marker": "o", "linestyle": ""},
            "cubic": {"color": "black", "marker": "^", "linestyle": ""},
            "gradient affine": {"color": "black"},
            "gradient shape": {"color": "black", "linestyle": ":"},
            "second order": {"color": "black", "linestyle": "--", "linewidth": 0.8}}).items():
        axes[0, 0].plot([], [], label=name, **style)
    figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=9, frameon=False)
    figure.suptitle("Manufactured motions: root mean square errors of every scheme, "
                    + ", ".join(sorted({f"{row[-2]} on {row[-1]} thread(s)" for row in rows})))
    figure.savefig(file, dpi=110)


def kept(file):
    """Rows of an earlier run, whole tables only."""
    with open(file, newline="") as lines:
        rows = [tuple(row) for row in csv.reader(lines)][1:]
    return [row for row in rows if sum(other[:6] == row[:6] for other in rows) == len(CELLS)]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("-o", "--output", type=Path, default=Path(__file__).parent / "figures", help="folder")
    parser.add_argument("--only", default="", help="schemes whose name holds this")
    parser.add_argument("--per-cell", type=int, nargs="+", choices=PER_CELL, default=PER_CELL)
    parser.add_argument("--resume", action="store_true", help="keep the rows that are there")
    parser.add_argument("--precision", choices=("f64", "f32"), default="f64")
    parser.add_argument("--threads", type=int, default=1)
    options = parser.parse_args()
    runtime.start("cpu", threads=options.threads)
    options.output.mkdir(parents=True, exist_ok=True)
    file = options.output / "order_tables.csv"
    rows = kept(file) if options.resume and file.exists() else []
    for per_cell, scheme, case in itertools.product(options.per_cell, EVERY, CASES):
        ratio = f"{scheme.flip_ratio:g}" if "flip" in scheme.transfer else ""
        key = case, scheme.kernel, scheme.gradient, scheme.transfer, ratio, str(per_cell)
        if options.only not in str(scheme) or any(row[:6] == key for row in rows):
            continue
        new = list(table(case, scheme, key, options.precision, options.threads))
        rows.extend(new)
        with open(file, "w", newline="") as lines:
            csv.writer(lines).writerows([COLUMNS, *rows])
        print(f"{case:6s} {scheme!s:28s} {per_cell} per cell: displacement " + " ".join(row[7] for row in new)
              + ", stress " + " ".join(row[9] for row in new), flush=True)
    draw(rows, options.output / "order_tables.png")


if __name__ == "__main__":
    main()
