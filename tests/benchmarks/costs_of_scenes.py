"""What real scenes add to the bulk of a step: rows of `check_costs.py` from the table of `scene_runs.py`."""

import csv
import time
from dataclasses import replace

import numpy as np
import scene_runs
from costs_in_turn import PAIRS, WARM_UP
from scipy.optimize import nnls

from snowmpm.advice.budget import Budget
from snowmpm.advice.facts import SceneFacts
from snowmpm.components.rigid_bodies.atlas import stack
from snowmpm.measured import costs
from snowmpm.methods import METHODS
from snowmpm.scenes import load_scene
from snowmpm.scenes.library import library
from snowmpm.schemes import TRANSFERS
from snowmpm.setup.build import build

LEAST_STEPS, SMALL = 20, 6000
STEPPING = ("scatter", "gather", "grid", "contact", "sort", "rest")
TEXTS = ("scene", "settings", "machine", "precision")


def in_scenes():
    """What real scenes add to the bulk: least squares, without negative costs, over the stages of the library's runs
    (`scene_runs.py`), each by the size of its scene at the start. Times are those of a machine as fast as the fastest
    of these runs, by the speed that was sampled while they ran."""
    with open(scene_runs.TABLE, newline="", encoding="utf-8") as file:
        every = [Run(row) for row in csv.DictReader(file) if row["scene"] in library() and not row["settings"]
                 and int(row["steps"]) >= LEAST_STEPS]
    runs, columns = [run for run in every if run.method.grid], [run for run in every if run.method.plan]
    vector, python = (min(getattr(run, name) for run in runs) for name in ("vector", "python"))
    for run in every:
        run.slow = run.vector / vector
    yield "speed", 0, "", "vector", vector
    yield "speed", 0, "", "python", python
    found = fitted(runs, lambda run: run.ns("scatter", "gather"), {
        "call": lambda run: 1.0,
        **{("bulk", dim, ""): lambda run, dim=dim: (run.dim == dim) * run.bulk for dim in (2, 3)},
        **{("home block", dim, ""): lambda run, dim=dim: (run.dim == dim) * run.load.blocks for dim in (2, 3)},
        **{("more", dim, "aflip"): lambda run, dim=dim: (run.dim == dim) * run.flip * run.load.n for dim in (2, 3)}})
    del found["call"]
    found |= fitted(runs, lambda run: run.ns("grid"), {
        "call": lambda run: 1.0,
        **{("node block", dim, name): lambda run, dim=dim, flip=flip: (run.dim == dim and run.flip == flip)
           * run.load.node_blocks for dim in (2, 3) for name, flip in (("apic", False), ("flip", True))},
        **{("carried", dim): lambda run, dim=dim: (run.dim == dim) * run.load.moving for dim in (2, 3)}})
    del found["call"]
    carried = {dim: found.pop(("carried", dim)) for dim in (2, 3)}
    found |= fitted(runs, lambda run: run.ns("contact"), {
        "surface": lambda run: run.load.surfaces, "strong": lambda run: pieces(run.load, "strong segment"),
        **{("moving", dim, ""): lambda run, dim=dim: (run.dim == dim) * run.load.moving for dim in (2, 3)},
        **{("contact block", dim, ""): lambda run, dim=dim: (run.dim == dim) * run.load.contact_blocks
           for dim in (2, 3)}})
    for dim in (2, 3):
        found["moving", dim, ""] += carried[dim]
    found |= fitted(runs, lambda run: run.ns("rest"), {
        "call": lambda run: 1.0, "watched": lambda run: run.watched,
        "free": lambda run: (run.dim == 2) * bodies(run.load),
        "segment": lambda run: pieces(run.load, "segment", "element")})
    del found["call"]
    calls = np.median([run.ns(*STEPPING) - run.without_calls(found) for run in runs if run.load.n < SMALL])
    for dim in (2, 3):
        for (what, of, name), ns in ((key, ns) for key, ns in found.items() if isinstance(key, tuple)):
            if of == dim:
                yield what, dim, "f32", name, ns
        for method in ("mpm", "sph"):
            yield f"{method} rigid_bodies", dim, "f32", "body", found["free"] * (1.0 if dim == 2 else stacks())
            yield f"{method} structures", dim, "f32", "segment", found["segment"]
            if any(pieces(run.load, "strong segment") for run in runs):
                yield f"{method} structures", dim, "f32", "strong segment", found["strong"]
        for what in ("surface", "watched"):
            yield what, dim, "f32", "", found[what]
        yield "more", dim, "f32", "flip", found["more", dim, "aflip"]
        own = [run for run in runs if run.dim == dim]
        yield "sort", dim, "f32", "", np.median([run.ns("sort") / run.load.n for run in own])
        yield "call", dim, "f32", "mpm", calls
        yield "call", dim, "f32", "sph", calls
        written = [run for run in own if run.frames]
        parts = fitted(written, lambda run: run.ns("output", a="frames"), {
            "fixed": lambda run: 1.0, "audit": lambda run: run.load.n})
        yield "frame", dim, "f32", "fixed", parts["fixed"]
        yield "frame", dim, "f32", "audit", parts["audit"]
        yield "frame", dim, "f32", "number", 0.0
        if dim == 3:
            yield "frame", dim, "f32", "depth", np.median([run.ns("output", a="frames") for run in columns])
        begun = fitted(own, lambda run: 1e9 * run.start / run.slow, {
            "fixed": lambda run: 1.0, "particle": lambda run: run.load.n})
        yield "start", dim, "f32", "fixed", begun["fixed"]
        yield "start", dim, "f32", "particle", begun["particle"]


class Run:
    """A row of the table of runs, with the sizes of its scene."""

    def __init__(self, row):
        scene = load_scene(row["scene"])
        model = build(scene)
        budget = Budget(SceneFacts(scene, model, model.solver()))
        self.method = METHODS[scene.solver.method].capabilities
        self.dim, self.load, self.flip = scene.dimension, budget.step_load, TRANSFERS[scene.solver.transfer].flip
        self.watched = float(bool(model.obstacles))
        plain = replace(budget.scheme, transfer="apic")
        self.bulk = costs.bulk(plain, budget.step_load)
        self.row = {key: float(value) for key, value in row.items() if key not in TEXTS}
        self.vector, self.python, self.slow = self.row["vector"], self.row["python"], 1.0
        self.frames, self.start = self.row["frames"], self.row["start"]

    def without_calls(self, found):
        """ns of a step by the costs found, but for calls of kernels: what is left over in small scenes."""
        dim, load, flip = self.dim, self.load, "flip" if self.flip else "apic"
        return (found["bulk", dim, ""] * self.bulk + found["home block", dim, ""] * load.blocks
                + self.flip * found["more", dim, "aflip"] * load.n + found["node block", dim, flip] * load.node_blocks
                + found["contact block", dim, ""] * load.contact_blocks + found["surface"] * load.surfaces
                + found["moving", dim, ""] * load.moving + found["watched"] * self.watched + self.ns("sort")
                + found["free"] * bodies(load) * (dim == 2) + found["segment"] * pieces(load, "segment", "element"))

    def ns(self, *stages, a="steps"):
        """Of some stages a step, or `a` frame."""
        return 1e9 * sum(self.row[stage] for stage in stages) / self.row[a] / self.slow


def bodies(load):
    """Rigid bodies with mass of a scene."""
    return load.components.get("rigid_bodies", {}).get("body", 0)


def pieces(load, *names):
    """Pieces of structures of a scene, of these kinds together."""
    work = load.components.get("structures", {})
    return sum(work.get(name, 0) for name in names)


def stacks():
    """Time of a step of six free blocks on each other in 3-D over that in 2-D."""
    worlds, spent = {dim: stack(6, 1.0, dim) for dim in (2, 3)}, {2: 0.0, 3: 0.0}
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
