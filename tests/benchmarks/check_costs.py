"""Costs that `snowmpm check` goes by: collected from the tables of the other benchmarks; SPH, columns, PIC, averaged
hats and water here.

    python tests/benchmarks/check_costs.py [-o FILE] [--only WHAT]

Needs figures/mpm_step.csv and figures/stress_update.csv for the bulk, and the table of `scene_runs.py` for what real
scenes add to it. Steps of SPH: median of ten. Columns: the least of fifty steps, of many and of few, brought to the
speed of the table's machine. All by the processor time of one thread. --only: measure these rows, keep the table's
others.
"""

import argparse
import csv
import time
from dataclasses import replace
from pathlib import Path

import mpm_step
import numpy as np
import scene_runs
from scipy.optimize import nnls

from snowmpm import Simulation
from snowmpm.advice.budget import Budget
from snowmpm.advice.calibration import Speed, measured_speed
from snowmpm.advice.facts import SceneFacts
from snowmpm.compiler import runtime
from snowmpm.measured import costs
from snowmpm.methods import METHODS
from snowmpm.scenes import load_scene
from snowmpm.scenes.schema import Scene
from snowmpm.schemes import BASES, TRANSFERS
from snowmpm.setup.build import build
from snowmpm.study.atlas import standing

FIGURES = Path(__file__).parent / "figures"
PLAIN = {"particles": ("250047", "250000"), "threads": "1", "basis": "quadratic", "transfer": "apic",
         "gradient": "affine"}
LEAST_STEPS, SMALL = 20, 6000
FIELD, FASTEST_OF = 250, 50
"""Side [cells] of a sheet of many columns; steps of which the fastest counts."""
PLAIN_STEP, PAIRS, WARM_UP = "quadratic affine apic", 41, 6
STEPPING = ("scatter", "gather", "grid", "contact", "sort", "rest")
TEXTS = ("scene", "settings", "machine", "precision")


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


def columns():
    """ns a column of a step of the depth-averaged method with Voellmy friction, of a sheet that slides down a plane;
    ns of a step of hardly any."""
    for precision in ("f32", "f64"):
        many, few = (_least_step(side, precision) for side in (FIELD, 4))
        speed = measured_speed().over(Speed(*costs.reference_speed()))
        a_column = (many[1] - few[1]) / (many[0] - few[0])
        yield "step", 3, precision, "depth", a_column / speed[0]
        if precision == "f32":
            yield "call", 3, "f32", "depth", (few[1] - few[0] * a_column) / speed[1]


def _least_step(side, precision):
    """-> (columns, ns of the fastest step) of a square of so many cells."""
    region = {"polygon": [[8.0, 8.0], [8.0 + side, 8.0], [8.0 + side, 8.0 + side], [8.0, 8.0 + side]]}
    scene = Scene.model_validate({
        "name": "columns", "dimension": 3, "end_time": 1.0, "solver": {"method": "depth", "dx": 1.0,
                                                                       "precision": precision},
        "domain": {"min": [0.0, 0.0, -100.0 - side], "max": [side + 40.0, side + 16.0, 100.0]},
        "terrain": {"kind": "plane", "point": [0.0, 0.0, 0.0], "angle": 20.0,
                    "friction": {"law": "voellmy", "mu": 0.2, "xi": 1500.0}},
        "materials": {"snow": {"kind": "elastic", "density": 250.0, "youngs_modulus": 1e6, "poisson_ratio": 0.3}},
        "bodies": [{"name": "sheet", "material": "snow", "velocity": [5.0, 0.0, 0.0],
                    "shape": {"kind": "layer", "bottom": 0.0, "top": 1.0, "region": region}}]})
    solver, times = Simulation(scene).solver, []
    for _ in range(3 + FASTEST_OF):
        start = time.process_time()
        solver.step(solver.stable_dt()[0])
        times.append(time.process_time() - start)
    return solver.particles.count, 1e9 * min(times[3:])


def water():
    """ns that water in the pores adds to a step: a particle, or a column and layer, and a step. Of many and of few
    particles with and without it, step by step in turn."""
    for dim, sides in ((2, (10, 60)), (3, (4, 16))):
        yield from _more_by_water("u_p", dim, "f64", [_soaked(dim, side) for side in sides], 1)
        yield from _more_by_water("v_w", dim, "f64", [_layered(dim, side) for side in sides], 1)
        yield from _more_by_water("seepage", dim, "f64", [_seeping(dim, side) for side in sides], 1)
    for precision in ("f32", "f64"):
        yield from _more_by_water("one_phase", 3, precision, [_slush(side, precision) for side in (8, 100)], LAYERS)
        yield from _more_by_water("two_phase", 3, precision, [_mixed(side, precision) for side in (8, 100)], LAYERS)


LAYERS, TURNS = 10, 15
"""Of the mesh over a column; steps of which the median counts."""


def _more_by_water(scheme, dim, precision, pairs, layers):
    few, many = (_difference(pair) for pair in pairs)
    speed = measured_speed().over(Speed(*costs.reference_speed()))[0]
    a_particle = (many[1] - few[1]) / (many[0] - few[0]) / speed
    yield "water", dim, precision, scheme, a_particle / layers
    yield "water call", dim, precision, scheme, max(0.0, few[1] / speed - few[0] * a_particle)


def _difference(tables):
    """-> (particles, median over steps of the ns that the first scene takes more than the second)."""
    solvers, times = [Simulation(Scene.model_validate(table)).solver for table in tables], []
    for _ in range(3 + TURNS):
        taken = []
        for solver in solvers:
            start = time.process_time()
            solver.step(solver.stable_dt()[0])
            taken.append(time.process_time() - start)
        times.append(taken[0] - taken[1])
    return solvers[0].particles.count, 1e9 * float(np.median(times[3:]))


def _soaked(dim, side):
    """Tables of a block of so many cells a side with water and without."""
    dry = {"name": "soaked", "dimension": dim, "end_time": 1.0, "solver": {"dx": 1.0, "precision": "f64"},
           "domain": {"min": [0.0] * dim, "max": [float(side)] * (dim - 1) + [side + 4.0], "boundary": "slip"},
           "materials": {"snow": {"kind": "elastic", "density": 400.0, "youngs_modulus": 1e7, "poisson_ratio": 0.2}},
           "bodies": [{"name": "block", "material": "snow", "shape": {
               "kind": "box", "min": [0.0] * dim, "max": [float(side)] * dim}}]}
    return {**dry, "water": {"permeability": 1e-9}}, dry


def _layered(dim, side):
    """The same with particles of water beside those of snow, and twice as many dry particles."""
    _, dry = _soaked(dim, side)
    own = {**dry, "solver": {**dry["solver"], "transfer": "aflip"}}
    twice = {**own, "solver": {**own["solver"], "particles_per_cell": 2 ** (dim + 1)}}
    return {**own, "water": {"scheme": "v_w", "permeability": 1e-9}}, twice


def _seeping(dim, side):
    """The same for SPH, with particles of water at whose steps grains are at rest, and dry."""
    _, dry = _soaked(dim, side)
    dry = {**dry, "solver": {**dry["solver"], "method": "sph"}}
    return {**dry, "water": {"scheme": "seepage", "permeability": 1e-7}}, dry


def _slush(side, precision):
    """Tables of a sheet of so many cells a side on a plane, with water and without."""
    region = {"x": [8.0, 8.0 + side], "y": [8.0, 8.0 + side]}
    dry = {"name": "slush", "dimension": 3, "end_time": 1.0,
           "solver": {"method": "depth", "dx": 1.0, "precision": precision},
           "domain": {"min": [0.0, 0.0, -100.0 - side], "max": [side + 40.0, side + 16.0, 100.0]},
           "terrain": {"kind": "plane", "point": [0.0, 0.0, 0.0], "angle": 20.0, "friction": 0.2},
           "materials": {"snow": {"kind": "elastic", "density": 400.0, "youngs_modulus": 1e6, "poisson_ratio": 0.3}},
           "bodies": [{"name": "sheet", "material": "snow", "shape": {
               "kind": "layer", "bottom": 0.0, "top": 1.0, "region": region}}]}
    return {**dry, "water": {"scheme": "one_phase", "level": 0.5, "consolidation": 0.01, "layers": LAYERS}}, dry


def _mixed(side, precision):
    """The same with columns of water beside those of grains, and as many dry columns."""
    _, dry = _slush(side, precision)
    dry["materials"]["snow"]["density"] = 1500.0
    water = {"scheme": "two_phase", "grain_density": 2500.0, "consolidation": 0.01, "layers": LAYERS,
             "drag": {"law": "anderson", "terminal_velocity": 1e-3}}
    return {**dry, "water": water}, {**dry, "solver": {**dry["solver"], "particles_per_cell": 8}}


def in_scenes():
    """What real scenes add to the bulk: least squares, without negative costs, over the stages of the library's runs
    (`scene_runs.py`), each by the size of its scene at the start. Times are those of a machine as fast as the fastest
    of these runs, by the speed that was sampled while they ran."""
    with open(scene_runs.TABLE, newline="", encoding="utf-8") as file:
        every = [Run(row) for row in csv.DictReader(file) if not row["settings"] and int(row["steps"]) >= LEAST_STEPS]
    runs, columns = [run for run in every if run.method.grid], [run for run in every if run.method.plan]
    vector, python = (min(getattr(run, name) for run in runs) for name in ("vector", "python"))
    for run in every:
        run.slow = run.vector / vector
    yield "speed", 0, "", "vector", vector
    yield "speed", 0, "", "python", python
    found = fitted(runs, lambda run: run.ns("scatter", "gather"), {
        "call": lambda run: 1.0,
        **{("bulk", dim, ""): lambda run, dim=dim: (run.dim == dim) * run.bulk for dim in (2, 3)},
        **{("home block", dim, ""): lambda run, dim=dim: (run.dim == dim) * run.crowd.blocks for dim in (2, 3)},
        **{("more", dim, "aflip"): lambda run, dim=dim: (run.dim == dim) * run.flip * run.crowd.n for dim in (2, 3)}})
    del found["call"]
    found |= fitted(runs, lambda run: run.ns("grid"), {
        "call": lambda run: 1.0,
        **{("node block", dim, name): lambda run, dim=dim, flip=flip: (run.dim == dim and run.flip == flip)
           * run.crowd.node_blocks for dim in (2, 3) for name, flip in (("apic", False), ("flip", True))},
        **{("carried", dim): lambda run, dim=dim: (run.dim == dim) * run.crowd.moving for dim in (2, 3)}})
    del found["call"]
    carried = {dim: found.pop(("carried", dim)) for dim in (2, 3)}
    found |= fitted(runs, lambda run: run.ns("contact"), {
        "surface": lambda run: run.crowd.surfaces, "strong": lambda run: run.crowd.strong,
        **{("moving", dim, ""): lambda run, dim=dim: (run.dim == dim) * run.crowd.moving for dim in (2, 3)},
        **{("contact block", dim, ""): lambda run, dim=dim: (run.dim == dim) * run.crowd.contact_blocks
           for dim in (2, 3)}})
    for dim in (2, 3):
        found["moving", dim, ""] += carried[dim]
    found |= fitted(runs, lambda run: run.ns("rest"), {
        "call": lambda run: 1.0, "watched": lambda run: run.watched,
        "free": lambda run: (run.dim == 2) * run.crowd.free, "segment": lambda run: run.crowd.segments})
    del found["call"]
    calls = np.median([run.ns(*STEPPING) - run.without_calls(found) for run in runs if run.crowd.n < SMALL])
    for dim in (2, 3):
        for (what, of, name), ns in ((key, ns) for key, ns in found.items() if isinstance(key, tuple)):
            if of == dim:
                yield what, dim, "f32", name, ns
        yield "mover", dim, "f32", "free", found["free"] * (1.0 if dim == 2 else stacks())
        yield "mover", dim, "f32", "segment", found["segment"]
        if any(run.crowd.strong for run in runs):
            yield "mover", dim, "f32", "strong", found["strong"]
        for what in ("surface", "watched"):
            yield what, dim, "f32", "", found[what]
        yield "more", dim, "f32", "flip", found["more", dim, "aflip"]
        own = [run for run in runs if run.dim == dim]
        yield "sort", dim, "f32", "", np.median([run.ns("sort") / run.crowd.n for run in own])
        yield "call", dim, "f32", "mpm", calls
        yield "call", dim, "f32", "sph", calls
        written = [run for run in own if run.frames]
        parts = fitted(written, lambda run: run.ns("output", a="frames"), {
            "fixed": lambda run: 1.0, "audit": lambda run: run.crowd.n})
        yield "frame", dim, "f32", "fixed", parts["fixed"]
        yield "frame", dim, "f32", "audit", parts["audit"]
        yield "frame", dim, "f32", "number", 0.0
        if dim == 3:
            yield "frame", dim, "f32", "depth", np.median([run.ns("output", a="frames") for run in columns])
        begun = fitted(own, lambda run: 1e9 * run.start / run.slow, {
            "fixed": lambda run: 1.0, "particle": lambda run: run.crowd.n})
        yield "start", dim, "f32", "fixed", begun["fixed"]
        yield "start", dim, "f32", "particle", begun["particle"]


class Run:
    """A row of the table of runs, with the sizes of its scene."""

    def __init__(self, row):
        scene = load_scene(row["scene"])
        model = build(scene)
        budget = Budget(SceneFacts(scene, model, model.solver()))
        self.method = METHODS[scene.solver.method].capabilities
        self.dim, self.crowd, self.flip = scene.dimension, budget.crowd, TRANSFERS[scene.solver.transfer].flip
        self.watched = float(bool(model.obstacles))
        plain = replace(budget.scheme, transfer="apic")
        self.bulk = costs.bulk(plain, budget.crowd)
        self.row = {key: float(value) for key, value in row.items() if key not in TEXTS}
        self.vector, self.python, self.slow = self.row["vector"], self.row["python"], 1.0
        self.frames, self.start = self.row["frames"], self.row["start"]

    def without_calls(self, found):
        """ns of a step by the costs found, but for calls of kernels: what is left over in small scenes."""
        dim, crowd, flip = self.dim, self.crowd, "flip" if self.flip else "apic"
        return (found["bulk", dim, ""] * self.bulk + found["home block", dim, ""] * crowd.blocks
                + self.flip * found["more", dim, "aflip"] * crowd.n + found["node block", dim, flip] * crowd.node_blocks
                + found["contact block", dim, ""] * crowd.contact_blocks + found["surface"] * crowd.surfaces
                + found["moving", dim, ""] * crowd.moving + found["watched"] * self.watched + self.ns("sort")
                + found["free"] * crowd.free * (dim == 2) + found["segment"] * crowd.segments)

    def ns(self, *stages, a="steps"):
        """Of some stages a step, or `a` frame."""
        return 1e9 * sum(self.row[stage] for stage in stages) / self.row[a] / self.slow


def stacks():
    """Time of a step of six free blocks on each other in 3-D over that in 2-D."""
    worlds, spent = {dim: standing.stack(6, 1.0, dim) for dim in (2, 3)}, {2: 0.0, 3: 0.0}
    for k in range(WARM_UP + PAIRS):
        for dim, world in worlds.items():
            start = time.process_time()
            world.advance(2e-3 * k, 2e-3, -9.81 * np.eye(dim)[-1], np.zeros((6, 4 if dim == 2 else 7)))
            spent[dim] += (k >= WARM_UP) * (time.process_time() - start)
    return spent[3] / spent[2]


def fitted(runs, cost, terms):
    """Non-negative factor of each term, so that their sum is the cost of each run in the mean over relative errors."""
    matrix = np.array([[float(term(run)) for term in terms.values()] for run in runs])
    wanted = np.array([cost(run) for run in runs])
    used = wanted > 0.0
    size = np.maximum(np.abs(matrix).max(axis=0), 1e-300)
    factors, _ = nnls(matrix[used] / size / wanted[used, None], np.ones(used.sum()))
    return dict(zip(terms, factors / size, strict=True))


def pic():
    """ns a particle that PIC takes more than APIC: the median ratio of steps taken in turn, in blocks in motion, by the
    step of APIC in the table."""
    for dim in (2, 3):
        solvers = [mpm_step.make_solver(f"half{dim}", 60_000, "f32", transfer=name) for name in ("apic", "pic")]
        ratios = []
        for _ in range(3 + PAIRS):
            taken = []
            for solver in solvers:
                dt, start = solver.stable_dt()[0], time.process_time()
                solver.step(dt)
                taken.append(time.process_time() - start)
            ratios.append(taken[1] / taken[0])
        yield "more", dim, "f32", "pic", (np.median(ratios[3:]) - 1.0) * costs.row("step", dim, "f32", PLAIN_STEP)


def averaged_hats():
    """ns a particle that averaged hats take more than the splines, as that of the quadratic one with the same gradient
    and transfer and the median ratio of steps taken in turn."""
    for dim in (2, 3):
        names = ["quadratic", *(name for name, basis in BASES.items() if basis.box)]
        solvers = [mpm_step.make_solver(f"half{dim}", 60_000, "f32", transfer="flip", gradient="shape", kernel=name)
                   for name in names]
        taken = []
        for _ in range(3 + PAIRS):
            taken.append([])
            for solver in solvers:
                dt, start = solver.stable_dt()[0], time.process_time()
                solver.step(dt)
                taken[-1].append(time.process_time() - start)
        shape = costs.row("more", dim, "f32", "quadratic shape")
        whole = costs.row("step", dim, "f32", PLAIN_STEP) + costs.row("more", dim, "f32", "flip") + shape
        for k, name in enumerate(names[1:], 1):
            ratio = np.median([row[k] / row[0] for row in taken[3:]])
            yield "more", dim, "f32", f"{name} shape", shape + (ratio - 1.0) * whole


ROWS = {"step": steps, "law": laws, "sph": sph, "columns": columns, "pic": pic, "averaged_hats": averaged_hats,
        "water": water, "scenes": in_scenes}
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
