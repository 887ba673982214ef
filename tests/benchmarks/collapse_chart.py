"""Charts of error against work: collapses in 3-D, each beside one on a finer grid (`particles_a_cell.py`)."""

import argparse
import csv
import time
from pathlib import Path

import numpy as np

from snowmpm.compiler import runtime
from snowmpm.running.simulation import Simulation
from snowmpm.scenes import load_scene

FIGURES = Path(__file__).parent / "figures"
LOADING = 30.0
"""Times the median of all steps: a step that takes longer loads kernels."""


def ran(settings, cell):
    """Particles, processor seconds, audits and {plan cell of `cell` [m]: mass} of a run of `column_collapse_3d`."""
    simulation = Simulation(load_scene("column_collapse_3d", settings))
    end, interval = simulation.scene.end_time, simulation.scene.output.interval
    simulation.step()
    spent, audits = [], []
    for until in np.arange(1, round(end / interval) + 1) * interval:
        while simulation.time < until:
            began = time.process_time()
            simulation.step(until)
            spent.append(time.process_time() - began)
        audits.append(simulation.audit())
    spent, fields = np.array(spent), simulation.particles
    place, number = np.unique(np.floor(fields["position"][:, :-1] / cell).astype(int), axis=0, return_inverse=True)
    mass = dict(zip(map(tuple, place), np.bincount(number.ravel(), fields["mass"]), strict=True))
    return simulation.n_particles, float(spent[spent < LOADING * np.median(spent)].sum()), audits, mass


def compared(run, reference):
    """Columns `particles`, `seconds`, `front` and `depth` of what `ran` gives, beside that of a reference."""
    particles, seconds, audits, mass = run
    fronts, whole = ([audit["front_distance"] for audit in of] for of in (audits, reference[2]))
    cells = {*mass, *reference[3]}
    return {"particles": particles, "seconds": seconds,
            "front": float(np.abs(np.subtract(fronts, whole)).mean()),
            "depth": sum(abs(mass.get(at, 0.0) - reference[3].get(at, 0.0)) for at in cells)
            / sum(reference[3].values())}


def rounded(row):
    return {key: f"{value:.4g}" if isinstance(value, float) else value for key, value in row.items()}


def draw(rows, path, column, lines):
    """A line for each value of a column; lines: [(value, style, label)]."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(1, 2, figsize=(8, 3.4), sharex=True, layout="constrained")
    for axis, name, label in zip(axes, ("front", "depth"), ("front [m]", "deposit, share of the mass"), strict=True):
        for value, style, text in lines:
            points = sorted((float(row["seconds"]), float(row[name])) for row in rows
                            if float(row[column]) == value and float(row[name]) > 0.0)
            axis.loglog(*zip(*points, strict=True), style, label=text)
        axis.set(xlabel="processor seconds of the steps", title=f"off by: {label}")
    axes[0].legend()
    figure.savefig(path, dpi=110)


def command(summary, name, computed, column, lines):
    """Run a chart's command: compute rows, write the table and draw it; name: of both files."""
    parser = argparse.ArgumentParser(description=summary)
    parser.add_argument("-o", "--output", type=Path, default=FIGURES / f"{name}.csv")
    parser.add_argument("--picture", type=Path, default=FIGURES / f"{name}.png")
    parser.add_argument("--only-picture", action="store_true")
    options = parser.parse_args()
    if not options.only_picture:
        runtime.start("cpu", threads=1)
        rows = computed()
        with open(options.output, "w", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, rows[0])
            writer.writeheader()
            writer.writerows(rows)
    with open(options.output, newline="", encoding="utf-8") as file:
        draw(list(csv.DictReader(file)), options.picture, column, lines)
