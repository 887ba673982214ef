"""What the longer default step changes in two avalanches, beside what half the grid spacing changes.

    python tests/benchmarks/step_of_scenes.py [NAME ...] [-o FILE] [--runs FOLDER]

Each scene is run on one thread with the step of the program, with C = 0.4 and, where that is not too dear, with the
program's step on a finer grid. Work is counted in particle-steps, which do not depend on the machine. Runs that are in
FOLDER already are taken as they are.

Columns: scene; other: "C = 0.4" or "dx = ..."; particle_steps of the default and of the other; front: largest
difference of the front from the default's [m]; run_out: of both at the end [m]; peak_depth, peak_pressure: sum of the
differences over the cells of both maps over the sum of the default's; area: where the peak pressure passes 1 kPa, the
other's over the default's.
"""

import argparse
import csv
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import snowmpm
from snowmpm.compiler import runtime
from snowmpm.scenes import load_scene

TABLE = Path(__file__).parent / "figures" / "step_of_scenes.csv"
PRESSURE = 1e3
"""[Pa] from which a cell counts as reached."""


@dataclass(frozen=True)
class Case:
    """dx, finer [m], None: too dear; end_time [s]; map_cell [m]: the same on both grids."""

    dx: float
    finer: float | None
    end_time: float
    map_cell: float

    def settings(self, dx, **more):
        return {"solver.dx": dx, "end_time": self.end_time, "output.interval": 0.25, "output.map_cell": self.map_cell,
                **more}


CASES = {"avalanche_on_raster": Case(3.0, 1.5, 45.0, 30.0), "slab_release_resolved": Case(0.25, None, 3.0, 1.5)}
"""The weak layer of slab_release_resolved is 0.5 m thick: on grids of 0.3 m and more no slab breaks loose."""


def ran(folder, name, settings):
    """The run of a scene, computed unless it is in the folder."""
    if not (folder / "summary.json").exists():
        snowmpm.run(load_scene(name, settings), folder)
    return snowmpm.open_run(folder)


def difference(one, other, name):
    """Sum of |a - b| over the cells that both maps have, over the sum of a."""
    a, b = both(one, other, name)
    return float(np.abs(a - b).sum() / a.sum())


def both(one, other, name):
    """A map of two runs in the cells that both have."""
    parts, maps = [], [run.maps[name] for run in (one, other)]
    corners = [np.round((np.array([found.y0, found.x0]) + run.origin[1::-1]) / found.cell).astype(int)
               for found, run in zip(maps, (one, other), strict=True)]
    lower = np.max(corners, axis=0)
    upper = np.min([corner + found.values.shape for corner, found in zip(corners, maps, strict=True)], axis=0)
    for corner, found in zip(corners, maps, strict=True):
        rows, columns = (slice(low - at, high - at) for low, high, at in zip(lower, upper, corner, strict=True))
        parts.append(np.nan_to_num(found.values[rows, columns]))
    return parts


def front(one, other):
    """Largest distance of the fronts [m] at the times of `one` that `other` has reached."""
    times = one.history["time"]
    inside = times <= other.history["time"][-1]
    there = np.interp(times, other.history["time"], other.history["front_distance"])
    return float(np.abs(one.history["front_distance"] - there)[inside].max())


def row(name, label, one, other):
    areas = [int((values > PRESSURE).sum()) for values in both(one, other, "peak_pressure")]
    return {"scene": name, "other": label, "particle_steps": one.summary["particle_steps"],
            "of_other": other.summary["particle_steps"], "front": front(one, other),
            "run_out": one.summary["hazard"]["runout"], "run_out_of_other": other.summary["hazard"]["runout"],
            "peak_depth": difference(one, other, "peak_depth"),
            "peak_pressure": difference(one, other, "peak_pressure"), "area": areas[1] / areas[0]}


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("names", nargs="*", default=list(CASES))
    parser.add_argument("-o", "--output", type=Path, default=TABLE)
    parser.add_argument("--runs", type=Path)
    options = parser.parse_args()
    runtime.start("cpu", threads=1)
    folder = options.runs or Path(tempfile.mkdtemp())
    rows = []
    for name in options.names:
        case = CASES[name]
        usual = ran(folder / f"{name}-default", name, case.settings(case.dx))
        short = ran(folder / f"{name}-short", name, case.settings(case.dx, **{"solver.cfl": 0.4}))
        rows.append(row(name, "C = 0.4", usual, short))
        if case.finer:
            fine = ran(folder / f"{name}-fine", name, case.settings(case.finer))
            rows.append(row(name, f"dx = {case.finer:g} m for {case.dx:g} m", usual, fine))
    with open(options.output, "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, rows[0])
        writer.writeheader()
        for one in rows:
            writer.writerow({key: f"{value:.4g}" if isinstance(value, float) else value for key, value in one.items()})


if __name__ == "__main__":
    main()
