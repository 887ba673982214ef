"""Error against processor time of the ways to couple pore water: Terzaghi's column and Mandel's block.

    python tests/benchmarks/water_splits.py [--repeat N] [-o FOLDER]

Ten cells over the way of the water; Terzaghi's column at t = 0.1 s, Mandel's block at T = 0.1. semi_implicit and
explicit are the splits of `[water]` in explicit MPM; monolithic and fixed_stress those of implicit steps at rest; v_w
the scheme of that name, of two velocities. Each is run with several steps; the least processor time of the
repeats counts, all of them in turn. Writes water_splits.csv and .png.
"""

import argparse
import csv
import time
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter

from snowmpm.compiler import runtime
from snowmpm.study.problems import mandel, soaked_column

END = {"Terzaghi": 0.1, "Mandel": 0.1 / mandel.C_V}
"""[s]"""
DX = 0.1


def made(problem, **choices):
    """`Simulation` of a problem; choices: water, and keys of the solver's table."""
    water = choices.pop("water")
    if problem == "Mandel":
        return mandel.mandel(DX, water, **choices)
    return soaked_column.soaked_column(choices.pop("transfer", "apic"), solver=choices, **water)


def error(problem, simulation):
    """Of the pressure, over its start."""
    return mandel.pressure_error(simulation, DX) if problem == "Mandel" else soaked_column.pressure_error(simulation)


def of_scene(problem, split, size):
    """(steps, seconds, error) of explicit steps of the share `size` of the critical one."""
    simulation = made(problem, water={"split": split})
    return _timed(problem, simulation, int(np.ceil(END[problem] / (size * simulation.solver.critical_dt()[0]))))


def of_solved(problem, split, n):
    """The same of n implicit steps."""
    alpha = 0.5 if problem == "Terzaghi" else 1.0
    choices = {"implicit": {"time": "quasi_static", "dt": END[problem] / n}}
    return _timed(problem, made(problem, water={"split": split, "alpha": alpha}, **choices), n)


def _timed(problem, simulation, n):
    start = time.process_time()
    for _ in range(n):
        simulation.solver.step(END[problem] / n)
    return n, time.process_time() - start, error(problem, simulation)


def of_two_velocities(problem, scheme, size):
    """The same of water with a velocity of its own."""
    choices = {"water": {"scheme": scheme}, "transfer": "aflip"}
    simulation = made(problem, **choices)
    return _timed(problem, simulation, int(np.ceil(END[problem] / (size * simulation.solver.critical_dt()[0]))))


CASES = [*(("Terzaghi", "semi_implicit", share, of_scene) for share in (0.9, 0.7, 0.5, 0.25)),
         # Steps of 0.9 blow Mandel's block up, whose corner is free on two sides
         *(("Mandel", "semi_implicit", share, of_scene) for share in (0.7, 0.5, 0.25)),
         ("Terzaghi", "explicit", 0.9, of_scene), ("Mandel", "explicit", 0.7, of_scene),
         *((problem, way, n, of_solved) for problem in END for way in ("monolithic", "fixed_stress")
           for n in (5, 10, 20, 40)),
         *((problem, "v_w", share, of_two_velocities) for problem in END for share in (0.9, 0.5))]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeat", type=int, default=2)
    parser.add_argument("-o", "--out", type=Path, default=Path("."))
    options = parser.parse_args()
    runtime.start("cpu", threads=1)
    for problem in END:  # compiles
        of_scene(problem, "semi_implicit", 0.5)
        of_solved(problem, "monolithic", 2)
        made(problem, water={"scheme": "v_w"}, transfer="aflip").solver.step(1e-6)
    found = {}
    for _ in range(options.repeat):
        for problem, way, size, measure in CASES:
            n, seconds, off = measure(problem, way, size)
            least = min(seconds, found.get((problem, way, size), (0, np.inf, 0))[1])
            found[problem, way, size] = n, least, off
            print(f"{problem:9s} {way:15s} {size:5.2f} {n:7d} steps {least:8.3f} s  error {off:.4f}", flush=True)
    with open(options.out / "water_splits.csv", "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(["problem", "way", "share_of_critical_step_or_steps", "steps", "processor_seconds",
                         "pressure_error"])
        writer.writerows([*key, n, f"{seconds:.4g}", f"{off:.4g}"] for key, (n, seconds, off) in found.items())
    draw(found, options.out / "water_splits.png")


def draw(found, file):
    """Chart of both problems. found: {(problem, way, size): (steps, seconds, error)}."""
    figure = Figure(figsize=(9.0, 4.0), layout="constrained")
    for axes, problem in zip(figure.subplots(1, 2, sharey=True), END, strict=True):
        for k, way in enumerate(dict.fromkeys(name for _, name, _ in found)):
            points = sorted((seconds, off) for (own, name, _), (_, seconds, off) in found.items()
                            if name == way and own == problem)
            if points:
                axes.loglog(*zip(*points, strict=True), "osd^v"[k] + "-", color=f"C{k}", label=way.replace("_", "-"))
        axes.set(xlabel="processor time [s]", title=f"{problem}, ten cells")
        axes.xaxis.set_minor_formatter(NullFormatter())
        axes.set_xlim(0.1, 100.0)
        axes.grid(True, which="both", alpha=0.3)
        axes.legend()
    figure.axes[0].set_ylabel("largest error of the pressure, over its start")
    figure.savefig(file, dpi=110)


if __name__ == "__main__":
    main()
