"""What sleeping snow saves in whole scenes, and what it changes: the same scene with it and without, in turns.

    python tests/benchmarks/sleeping.py [NAME ...] [-o FILE] [--sleeping 0.01 0.02]
    python tests/benchmarks/sleeping.py --bound RUN [RUN ...] [--sleeping 0.02 0.05]

NAME: a library scene or a scene file. Both simulations of a scene advance by a frame in turns, in one process and on
one thread; what is compared is the processor time of their steps, audits left out. A row with cfl_factor 0.8 and
sleeping 0 compares the run without sleep with one of shorter steps: what a harmless change does.

Columns: scene; sleeping: solver.sleeping; steps_ratio: processor time of the steps without it over that with it;
late_ratio: the same of the last fifth of the frames; asleep: mean and last share of the mass; front: largest difference
of the front [m] and over dx; kinetic: largest difference of the kinetic energy over its peak; depth: sum of the
differences of the depth in plan at the end, in cells of 2 dx, over that of all; slept_energy [J]; residual: of the
momentum.

--bound: what sleep could save at best in a scene that was run without it, from the speeds in its frames: no more can
sleep than the mass slower than e sqrt(g dx). It leaves out that velocity gradients, neighbours and bonds that break
keep snow awake, and what looking for calm blocks costs.
"""

import argparse
import csv
import time as clock
from pathlib import Path

import numpy as np

from snowmpm import open_run
from snowmpm.compiler import runtime
from snowmpm.running.simulation import Simulation
from snowmpm.scenes import load_scene

TABLE = Path(__file__).parent / "figures" / "sleeping.csv"
CASES = {
    "avalanche_on_raster": {"solver.dx": 3.0, "end_time": 45.0, "output.interval": 1.0},
    "column_collapse_3d": {"solver.dx": 0.02, "end_time": 1.5, "output.interval": 0.05},
    "column_collapse_2d": {"end_time": 2.0, "output.interval": 0.05},
    "slab_release_resolved": {"solver.dx": 0.25, "end_time": 2.0, "output.interval": 0.1},
    "slab_release_2d": {"end_time": 6.0, "output.interval": 0.1},
}


def depth(simulation):
    """Mass in plan cells of 2 dx, {cell: mass}: depth at the density of the start, but for a factor."""
    fields, dx = simulation.particles, 2.0 * simulation.solver.dx
    cells, number = np.unique(np.floor(fields["position"][:, :-1] / dx).astype(int), axis=0, return_inverse=True)
    return dict(zip(map(tuple, cells), np.bincount(number.ravel(), fields["mass"]), strict=True))


def apart(one, other):
    """Sum of the differences of two `depth`s over the sum of the first."""
    return sum(abs(one.get(cell, 0.0) - other.get(cell, 0.0)) for cell in {*one, *other}) / sum(one.values())


def compared(name, settings, tolerance, cfl=1.0):
    """Row of a scene; cfl: factor of the second run's, which then sleeps no more than the first."""
    scenes = [load_scene(name, settings), load_scene(name, {**settings, "solver.sleeping": tolerance})]
    pair = [Simulation(scene) for scene in scenes]
    if cfl != 1.0:
        pair[1].solver.cfl *= cfl
    spent, rows = [[], []], [[], []]
    frames = np.arange(1, round(scenes[0].end_time / scenes[0].output.interval) + 1) * scenes[0].output.interval
    for simulation in pair:
        simulation.step()
    for k, until in enumerate(frames):
        for i in ((0, 1), (1, 0))[k % 2]:
            simulation, began = pair[i], clock.process_time()
            while simulation.time < until:
                simulation.step(until)
            spent[i].append(clock.process_time() - began)
            rows[i].append(simulation.audit())
        if k % 5 == 4:
            print(f"{name} t = {until:.3g}: seconds {sum(spent[0]):.1f} and {sum(spent[1]):.1f}, asleep"
                  f" {rows[1][-1].get('asleep_share', 0.0):.3f}, front {rows[0][-1]['front_distance']:.5g} and"
                  f" {rows[1][-1]['front_distance']:.5g}", flush=True)
    late = -max(1, len(frames) // 5)
    plain, asleep = rows
    dx = pair[0].solver.dx
    front = max(abs(a["front_distance"] - b["front_distance"]) for a, b in zip(plain, asleep, strict=True))
    kinetic = np.array([[row["kinetic_energy"] for row in part] for part in rows])
    shares = [row.get("asleep_share", 0.0) for row in asleep]
    return {"scene": name, "sleeping": tolerance, "cfl_factor": cfl, "particles": pair[0].n_particles,
            "seconds": sum(spent[0]), "steps_ratio": sum(spent[0]) / sum(spent[1]),
            "late_ratio": sum(spent[0][late:]) / sum(spent[1][late:]), "asleep_mean": float(np.mean(shares)),
            "asleep_last": shares[-1], "front": front, "front_over_dx": front / dx,
            "front_last": plain[-1]["front_distance"], "front_last_asleep": asleep[-1]["front_distance"],
            "kinetic": float(np.abs(kinetic[0] - kinetic[1]).max() / kinetic[0].max()),
            "depth": apart(*map(depth, pair)), "slept_energy": asleep[-1].get("slept_energy", 0.0),
            "peak_kinetic": float(kinetic.max()), "residual": asleep[-1]["momentum_residual"],
            "residual_plain": plain[-1]["momentum_residual"]}


def bound(run, tolerance):
    """(1 / (1 - s), s of the last fifth of the frames): s, the share of the mass slow enough to sleep, each frame
    counted by the steps up to it."""
    scene = run.scene
    calm = tolerance * np.sqrt(scene["gravity"] * scene["solver"]["dx"])
    shares = np.array([(np.linalg.norm(frame.fields["velocity"], axis=1) < calm).mean() for frame in run])
    steps = np.diff(run.history["steps"], prepend=0.0)[: len(shares)]
    return 1.0 / (1.0 - np.average(shares, weights=steps)), shares[-max(1, len(shares) // 5) :].mean()


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("names", nargs="*", default=list(CASES))
    parser.add_argument("-o", "--output", type=Path, default=TABLE)
    parser.add_argument("--sleeping", type=float, nargs="*", default=[0.02])
    parser.add_argument("--set", action="append", default=[], help="key=number for every scene")
    parser.add_argument("--bound", type=Path, nargs="*", default=[], metavar="RUN")
    parser.add_argument("--harmless", action="store_true", help="with the row of shorter steps")
    options = parser.parse_args()
    for path in options.bound:
        for tolerance in options.sleeping:
            best, late = bound(open_run(path), tolerance)
            print(f"{path}: e = {tolerance:g}: at best {best:.2f} times; {late:.0%} slow enough in the last fifth")
    if options.bound:
        return
    runtime.start("cpu", threads=1)
    more = {key: float(value) for key, value in (one.split("=") for one in options.set)}
    rows = []
    for name in options.names:
        for tolerance, cfl in [*((one, 1.0) for one in options.sleeping), *[(0.0, 0.8)] * options.harmless]:
            rows.append(compared(name, {**CASES.get(name, {}), **more}, tolerance, cfl))
            print({key: f"{value:.4g}" if isinstance(value, float) else value for key, value in rows[-1].items()},
                  flush=True)
    with open(options.output, "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, rows[0])
        writer.writeheader()
        for one in rows:
            writer.writerow({key: f"{value:.4g}" if isinstance(value, float) else value for key, value in one.items()})


if __name__ == "__main__":
    main()
