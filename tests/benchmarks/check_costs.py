"""Costs that `snowmpm check` goes by: collected from the tables of the other benchmarks; frames and SPH here.

    python tests/benchmarks/check_costs.py [-o FILE] [--only WHAT]

Needs figures/mpm_step.csv and figures/stress_update.csv. Frames: one of 100 000 particles is written with one field and
with six numbers more, the audit included, median of three each; the difference is what a number costs. Steps of SPH:
median of ten. Calls: steps of a scene with a few dozen particles on plane ground, median of two hundred. All by the
processor time of one thread. --only: measure these rows, keep the table's others.
"""

import argparse
import csv
import tempfile
import time
from pathlib import Path

import numpy as np

from snowmpm import Simulation, costs, runtime
from snowmpm.recorder import Recorder
from snowmpm.scenes.schema import Scene

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
        yield "block", dim, precision, "", grid * float(plain["per_block"])
        if precision == "f32":
            for row in own:
                more = float(row["ns"]) - float(row["update_grid"]) - float(plain["ns"]) + grid
                if row["basis"] + row["gradient"] != "quadraticaffine":
                    yield "more", dim, precision, f"{row['basis']} {row['gradient']}", more
                elif row["transfer"] != "apic":
                    yield "more", dim, precision, row["transfer"], more


def laws():
    for row in rows_of("stress_update.csv"):
        packed, single = float(row["ns_in_packs"]), float(row["ns_per_update"])
        if row["law"] != "copy":
            yield "law", int(row["dimension"]), row["precision"], row["law"], single if np.isnan(packed) else packed


def frames():
    """ns a particle of the audit, and of each number that is written."""
    for dim, side in ((2, 316), (3, 46)):
        spacing, found = 0.5, {}
        size = [side * spacing] * dim
        for fields in (["material"], ["material", "stress"]):
            scene = Scene.model_validate({
                "name": "frame", "dimension": dim, "end_time": 1.0, "gravity": 0.0, "output": {"fields": fields},
                "solver": {"dx": 1.0}, "domain": {"min": [-2.0] * dim, "max": [s + 2.0 for s in size]},
                "materials": {"snow": {"kind": "elastic", "density": 300.0, "youngs_modulus": 1e6,
                                       "poisson_ratio": 0.3}},
                "bodies": [{"name": "block", "material": "snow", "velocity": [1.0] + [0.0] * (dim - 1),
                            "shape": {"kind": "box", "min": [0.0] * dim, "max": size}}]})
            simulation, times = Simulation(scene), []
            for _ in range(3):
                simulation.step()
            with tempfile.TemporaryDirectory() as folder:
                recorder = Recorder(simulation, Path(folder))
                for _ in range(4):
                    simulation.step()
                    start = time.process_time()
                    recorder.frame()
                    times.append(time.process_time() - start)
            found[len(fields)] = 1e9 * np.median(times[1:]) / simulation.n_particles
        number = (found[2] - found[1]) / 6.0
        yield "frame", dim, "f32", "number", number
        yield "frame", dim, "f32", "audit", found[1] - 4.0 * number


def sph():
    """ns a particle of a step of SPH with the usual law, of a block in motion."""
    snow = {"kind": costs.USUAL_LAW, "density": 250.0, "youngs_modulus": 3e6, "poisson_ratio": 0.3,
            "critical_slope": 0.5, "cohesion": 0.0, "hardening": 1.0, "p0": 1e5}
    for dim, side in ((2, 120), (3, 24)):
        for precision in ("f32", "f64"):
            size = [float(side)] * dim
            scene = Scene.model_validate({
                "name": "sph", "dimension": dim, "end_time": 1.0, "gravity": 0.0,
                "solver": {"method": "sph", "dx": 1.0, "precision": precision},
                "domain": {"min": [-8.0] * dim, "max": [s + 8.0 for s in size]}, "materials": {"snow": snow},
                "bodies": [{"name": "block", "material": "snow", "velocity": [1.0] + [0.0] * (dim - 1),
                            "shape": {"kind": "box", "min": [0.0] * dim, "max": size}}]})
            solver, times = Simulation(scene).solver, []
            for _ in range(12):
                start = time.process_time()
                solver.step(solver.stable_dt()[0])
                times.append(time.process_time() - start)
            yield "step", dim, precision, "sph", 1e9 * np.median(times[2:]) / solver.particles.count


def calls():
    """ns of a step of a whole simulation with hardly anything in it."""
    for dim in (2, 3):
        for method in ("mpm", "sph"):
            size = [2.0] * dim
            scene = Scene.model_validate({
                "name": "call", "dimension": dim, "end_time": 1.0,
                "solver": {"method": method, "dx": 1.0 if method == "mpm" else 0.5},
                "terrain": {"kind": "plane"}, "domain": {"min": [-8.0] * dim, "max": [s + 8.0 for s in size]},
                "materials": {"snow": {"kind": "elastic", "density": 300.0, "youngs_modulus": 1e6,
                                       "poisson_ratio": 0.3}},
                "bodies": [{"name": "block", "material": "snow",
                            "shape": {"kind": "box", "min": [0.0] * dim, "max": size}}]})
            simulation, times = Simulation(scene), []
            for _ in range(220):
                start = time.process_time()
                simulation.step()
                times.append(time.process_time() - start)
            yield "call", dim, "f32", method, 1e9 * np.median(times[20:])


ROWS = {"step": steps, "law": laws, "frame": frames, "sph": sph, "call": calls}
"""What measures the rows of each kind."""


def kept(path, measured):
    """Rows of the table that is there but for those of the kinds measured."""
    if not path.exists():
        return []
    with open(path, newline="", encoding="utf-8") as file:
        rows = list(csv.reader(file))[1:]
    return [row for row in rows if _kind(row) not in measured]


def _kind(row):
    if row[3] == "sph" and row[0] == "step":
        return "sph"
    return "step" if row[0] in ("block", "more") else row[0]


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("-o", "--output", type=Path, default=costs.TABLE)
    parser.add_argument("--only", choices=ROWS, action="append", help="what to measure; all by default")
    options = parser.parse_args()
    measured = options.only or list(ROWS)
    runtime.start("cpu", threads=1)
    rows = kept(options.output, measured)
    for kind in measured:
        for *row, ns in ROWS[kind]():
            rows.append((*row, f"{ns:.4g}"))
            print(*rows[-1])
    options.output.parent.mkdir(parents=True, exist_ok=True)
    with open(options.output, "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(("what", "dimension", "precision", "name", "ns"))
        writer.writerows(rows)


if __name__ == "__main__":
    main()
