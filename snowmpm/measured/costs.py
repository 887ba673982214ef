"""What steps, frames and the start of a run cost, from the tables of the benchmarks.

Laws, kernels, precision: bulk of 250 000 particles (`tests/benchmarks/check_costs.py`). What a real scene adds to it,
blocks that are not full, contact, sorts, calls, frames: from runs of the library (`tests/benchmarks/scene_runs.py`).
Processor time of one thread of the machine that the table was measured on; `advice.calibration` compares others.
"""

import csv
import functools
from dataclasses import dataclass, field, replace
from pathlib import Path

from snowmpm.errors import InputError
from snowmpm.methods import METHODS
from snowmpm.registry import COMPONENTS, LAWS, OWN
from snowmpm.schemes import TRANSFERS

TABLE = Path(__file__).with_name("costs.csv")
USUAL_LAW = "cohesive_cam_clay"
"""Law of the steps in the table, half of the particles yielding."""
BASE = {"quadratic affine", "apic"}
"""Basis with gradient, and transfer, that the rows "step" of a grid were measured with: what others take more is in the
rows "more"."""


@dataclass(frozen=True)
class Scheme:
    """What the cost of a step hangs on."""

    dimension: int
    precision: str = "f32"
    kernel: str = "quadratic"
    gradient: str = "affine"
    transfer: str = "apic"
    method: str = "mpm"
    lengths: str = "constant"
    """smoothing lengths of SPH"""
    part: str = ""
    """of a method in two, what the rows of its steps are called"""

    @property
    def step(self):
        """Name of its rows."""
        return self.part or self.method

    @classmethod
    def of(cls, scene):
        solver = scene.solver
        return cls(scene.dimension, solver.precision, solver.kernel, solver.gradient, solver.transfer, solver.method,
                   solver.sph.lengths if solver.method == "sph" else "constant", solver.adapted)


@functools.cache
def table():
    """Rows of the table: {(what, dimension, precision, name): ns}."""
    with open(TABLE, newline="", encoding="utf-8") as file:
        return {(row["what"], int(row["dimension"]), row["precision"], row["name"]): float(row["ns"])
                for row in csv.DictReader(file)}


def row(what, dimension, precision, name):
    """ns of a row of the table. Raises InputError for one that is not there: no name is taken for another, or for 0."""
    try:
        return table()[what, dimension, precision, name]
    except KeyError:
        raise InputError(f"{TABLE.name}: has no row {what}, {dimension}, {precision}, {name}: its cost was not measured"
                         " (tests/benchmarks/check_costs.py)") from None


def on_grid(scheme):
    """Whether a method computes on a grid, whose blocks, nodes and contacts cost as well; of one that solves for its
    steps, that is in the cost of a particle."""
    able = METHODS[scheme.method].capabilities
    return able.grid and not able.solves


def transfers(scheme):
    """ns a particle of scatter and gather, or of a step of a method without a grid, with the usual law."""
    step, names = scheme.step, () if scheme.lengths == "constant" else (f"{scheme.method} {scheme.lengths}",)
    if on_grid(scheme):
        step = "quadratic affine apic"
        names = f"{scheme.kernel} {scheme.gradient}", scheme.transfer
    base = row("step", scheme.dimension, scheme.precision, step)
    found = base
    for name in names:
        if name not in BASE:
            # Measured in float32; what they add in float64 is more by as much as the whole step is
            single = row("step", scheme.dimension, "f32", step)
            found += row("more", scheme.dimension, "f32", name) * (base / single)
    return found


def usual_law(scheme):
    """ns of the update of `USUAL_LAW`."""
    return row("law", scheme.dimension, scheme.precision, USUAL_LAW)


def law(scheme, kind):
    """ns of a law's update more than that of `USUAL_LAW`."""
    return row("law", scheme.dimension, scheme.precision, taken_as(kind)) - usual_law(scheme)


def taken_as(kind):
    """Kind of the law whose cost a law is taken to have: its own; of a law that was added, whose cost nobody measured,
    that of the law of the program that it derives from, else of `USUAL_LAW`."""
    if LAWS.by.get(kind, OWN) == OWN:
        return kind
    own = {law: name for name, law in LAWS.items() if LAWS.by[name] == OWN}
    return next((own[base] for base in LAWS[kind].__mro__ if base in own), USUAL_LAW)


OF_PARTICLES = ("particle", "point", "layer", "cell")
"""Last words of what grows with the number of particles of what components count."""


def once(what, n):
    """Whether a row of a component is what each step has once: "step", or one of several kinds."""
    return what == "step" or (n == 1 and what.endswith(" step"))


@dataclass(frozen=True)
class StepLoad:
    """What a step has to do with: particles of each law kind, {kind: n}; home blocks of particles; blocks of nodes;
    contact blocks, those with nodes near a surface; surfaces: ground, sides and obstacles, moving ones of them."""

    particles: dict
    blocks: float
    node_blocks: float = 0.0
    contact_blocks: float = 0.0
    surfaces: int = 0
    moving: int = 0
    obstacles: int = 0
    rests: bool = False
    """whether it lies at rest until it is triggered: hardly anything of it yields, then or later"""
    components: dict = field(default_factory=dict)
    """of each component, what a step has to do for it (`stepping.component.Adapter.work`)"""

    @property
    def n(self):
        return sum(self.particles.values())

    def times(self, particles, blocks):
        """With so many times as many particles and blocks."""
        return StepLoad({kind: particles * n for kind, n in self.particles.items()}, blocks * self.blocks,
                     blocks * self.node_blocks, blocks * self.contact_blocks, self.surfaces, self.moving,
                     self.obstacles, self.rests, self._components_of(particles))

    def _components_of(self, particles):
        return {name: {what: particles * n if what.endswith(OF_PARTICLES) else n for what, n in work.items()}
                for name, work in self.components.items()}


def stages(scheme, step_load, settling=False):
    """Seconds of the stages of a step, by name: transfers and laws of particles, their blocks, nodes, contact, sorts,
    components, calls of kernels. Nothing moves far enough to be sorted while an initial state
    settles, and nothing is followed yet."""
    plain = replace(scheme, transfer="apic")
    more = transfers(scheme) - transfers(plain)
    full = _of(scheme, "bulk", "") if on_grid(scheme) else 1.0
    particles = full * bulk(plain, step_load) + step_load.n * more
    found = {"particles": particles, "blocks": 0.0, "nodes": 0.0, "contact": 0.0, "sorts": 0.0,
             **{name: component(scheme, name, work, settling) for name, work in step_load.components.items()},
             "calls": 1e9 * call(scheme)}
    if on_grid(scheme):
        wide = transfers(plain) / transfers(Scheme(scheme.dimension))
        flip = "flip" if TRANSFERS[scheme.transfer].flip else "apic"
        found["blocks"] = wide * step_load.blocks * _of(scheme, "home block", "")
        found["nodes"] = wide * step_load.node_blocks * _of(scheme, "node block", flip)
        found["contact"] = step_load.contact_blocks * _of(scheme, "contact block", "") + (
            step_load.surfaces * _of(scheme, "surface", "") + step_load.moving * _of(scheme, "moving", "")
            + bool(step_load.obstacles) * _of(scheme, "watched", ""))
        found["sorts"] = 0.0 if settling else step_load.n * _of(scheme, "sort", "")
    return {name: 1e-9 * ns for name, ns in found.items()}


def bulk(scheme, step_load):
    """ns of transfers and laws in full blocks of the benchmarks. Where nothing yields, a return map is a trial."""
    if METHODS[scheme.method].capabilities.plan:
        return step_load.n * transfers(scheme)  # columns have no stress
    kinds = {kind: "elastic" if step_load.rests and kind.endswith("cam_clay") else kind for kind in step_load.particles}
    return sum(n * (transfers(scheme) + law(scheme, kinds[kind])) for kind, n in step_load.particles.items())


def component(scheme, name, work, settling=False):
    """ns that a component adds to a step: work, {row: how often}; what is "followed" is not while an initial state
    settles."""
    return sum(n * _of_component(scheme, name, what) for what, n in work.items()
               if not (settling and what.startswith("followed")))


def _of_component(scheme, name, what):
    """ns of a row of a component. Measured in single precision alone, what it does with all particles takes more in
    double precision by as much as a step does."""
    if (own := COMPONENTS[name].costs.get(what)) is not None:
        return own
    component = f"{scheme.method} {name}"
    if (component, scheme.dimension, scheme.precision, what) in table():
        return row(component, scheme.dimension, scheme.precision, what)
    found = _of(scheme, component, what)
    if what == "particle" and on_grid(scheme):
        steps = [row("step", scheme.dimension, precision, "quadratic affine apic")
                 for precision in (scheme.precision, "f32")]
        found *= steps[0] / steps[1]
    return found


def _of(scheme, what, name):
    return row(what, scheme.dimension, "f32", name)


def call(scheme):
    """Seconds of a step that do not go with the number of particles: calls of kernels, and what is kept of a step."""
    return 1e-9 * _of(scheme, "call", scheme.step)


def step(scheme, step_load, settling=False):
    """Seconds of a step of a `StepLoad`."""
    return sum(stages(scheme, step_load, settling).values())


def frame(particles, numbers, scheme, obstacles=0):
    """Seconds of a frame of particles with so many numbers each, beside their positions, audit included; obstacles:
    whose poses and loads it has. A frame of the depth-averaged method was measured as a whole."""
    found, dimension = table(), scheme.dimension
    if scheme.method == "depth":
        return 1e-9 * row("frame", dimension, "f32", "depth")
    fixed = found["frame", dimension, "f32", "fixed"] + obstacles * found["frame", dimension, "f32", "obstacle"]
    return 1e-9 * (fixed + particles * (
        found["frame", dimension, "f32", "audit"] + (numbers + 3) * found["frame", dimension, "f32", "number"]))


def start(dimension, particles):
    """Seconds until the first step when the kernels were compiled before: imports, build, kernels from the disk."""
    found = table()
    return 1e-9 * (found["start", dimension, "f32", "fixed"] + particles * found["start", dimension, "f32", "particle"])


def reference_speed():
    """(vector, python) of `advice.calibration.Speed` of the machine of the table [ns]."""
    found = table()
    return found["speed", 0, "", "vector"], found["speed", 0, "", "python"]
