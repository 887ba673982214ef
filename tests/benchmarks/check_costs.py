"""Costs that `snowmpm check` goes by: collected from the tables of the other benchmarks, from runs of scenes
(`costs_of_scenes.py`), and measured (`costs_in_turn.py`, `costs_of_loads.py`).

    python tests/benchmarks/check_costs.py [-o FILE] [--only WHAT]

Needs figures/mpm_step.csv and figures/stress_update.csv for the bulk, and the table of `scene_runs.py` for what real
scenes add to it. Steps of SPH: median of ten. Columns: the least of fifty steps, of many and of few, brought to the
speed of the table's machine. All by the processor time of one thread. --only: measure these rows, keep the table's
others.
"""

import argparse
import csv
from pathlib import Path

import costs_in_turn as turns
import costs_of_loads as loads
import numpy as np
from costs_of_scenes import in_scenes

from snowmpm.compiler import runtime
from snowmpm.measured import costs

FIGURES = Path(__file__).parent / "figures"
PLAIN = {"particles": ("250047", "250000"), "threads": "1", "basis": "quadratic", "transfer": "apic",
         "gradient": "affine"}


def rows_of(name):
    with open(FIGURES / name, newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def steps():
    """ns of transfers and laws, and of a block, of each dimension and precision; what other schemes add."""
    rows = [row for row in rows_of("mpm_step.csv") if row["case"].startswith("half") and row["threads"] == "1"
            and row["particles"] in PLAIN["particles"]]
    for dim, precision in ((2, "f32"), (2, "f64"), (3, "f32"), (3, "f64")):
        own = [row for row in rows if row["case"].endswith(str(dim)) and row["precision"] == precision]
        plain = next(row for row in own if all(row[key] == PLAIN[key] for key in ("basis", "transfer", "gradient")))
        grid = float(plain["update_grid"])
        yield "step", dim, precision, "quadratic affine apic", float(plain["ns"]) - grid
        if precision == "f32":
            for row in own:
                more = float(row["ns"]) - float(row["update_grid"]) - float(plain["ns"]) + grid
                if row["basis"] + row["gradient"] != "quadraticaffine":
                    yield "more", dim, precision, f"{row['basis']} {row['gradient']}", more


def laws():
    for row in rows_of("stress_update.csv"):
        packed, single = float(row["ns_in_packs"]), float(row["ns_per_update"])
        if row["law"] != "copy":
            yield "law", int(row["dimension"]), row["precision"], row["law"], single if np.isnan(packed) else packed


ROWS = {"step": steps, "law": laws, "sph": turns.sph, "columns": turns.columns, "pic": turns.pic,
        "averaged_hats": turns.averaged_hats, "water": turns.water, "interface": turns.interface,
        "lengths": turns.lengths, "faces": loads.faces, "cells": loads.cells, "panels": loads.panels,
        "covers": loads.covers, "beds": loads.beds, "clouds": loads.clouds,
        "frameworks": loads.frameworks, "scenes": in_scenes}
"""What measures the rows of each kind."""


def kept(path, rows):
    """Rows of the table that is there but for those measured anew."""
    if not path.exists():
        return []
    with open(path, newline="", encoding="utf-8") as file:
        old = list(csv.reader(file))[1:]
    new = {row[:4] for row in rows}
    return [row for row in old if tuple(row[:4]) not in new]


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("-o", "--output", type=Path, default=costs.TABLE)
    parser.add_argument("--only", choices=ROWS, action="append", help="what to measure; all by default")
    options = parser.parse_args()
    measured = options.only or list(ROWS)
    runtime.start("cpu", threads=1)
    rows = []
    for kind in measured:
        for *row, ns in ROWS[kind]():
            rows.append((*map(str, row), f"{ns:.4g}"))
            print(*rows[-1])
    rows = kept(options.output, rows) + rows
    options.output.parent.mkdir(parents=True, exist_ok=True)
    with open(options.output, "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(("what", "dimension", "precision", "name", "ns"))
        writer.writerows(rows)


if __name__ == "__main__":
    main()
