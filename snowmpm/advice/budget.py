"""Expected run time of a scene by its parts, from measured costs."""

from dataclasses import dataclass, replace

import numpy as np

from snowmpm.advice.calibration import Speed
from snowmpm.measured import costs
from snowmpm.methods import METHODS
from snowmpm.registry import COMPONENTS
from snowmpm.running.description import expected_run_file, written_fields
from snowmpm.stepping.abilities import workload

WITHIN = 0.3
"""Largest relative error of the forecast for runs of the library."""
SETTLING_STEPS, OF_SAW_TESTS = 100, 500
"""Steps until an initial state has settled, about: two windows of `settling`; ten for a column that bends."""
PARALLEL = ("particles", "blocks", "nodes", "contact")
"""Stages of a step that run on several threads."""
GROWN = 4.0
"""Cells that hold snow in the mean of a run, over those of the release, about, where nothing tells how far it goes."""
EFFICIENCY = 0.9
"""Of each thread but the first."""
PYTHON = ("calls", "output", "start")
"""Parts whose time scales with the speed of Python rather than that of kernels."""


@dataclass(frozen=True)
class Payment:
    """One part of the run time: `what`, in words; seconds, share of the run."""

    what: str
    detail: str
    seconds: float | None
    share: float | None


class Budget:
    """Expected run time of a scene (`SceneFacts`), by its parts.

    threads: of the run. speed: `advice.calibration.Speed` of the machine; None for that of the table.
    """

    def __init__(self, facts, threads=1, speed=None):
        self.facts, scene = facts, facts.scene
        self.scheme = costs.Scheme.of(scene)
        laws = facts.model.all_laws
        kinds = list(dict.fromkeys(law.kind for law in laws))
        counts = np.bincount(facts.model.population.material, minlength=len(laws))
        self.particles = {kind: int(sum(n for n, law in zip(counts, laws, strict=True) if law.kind == kind))
                          for kind in kinds}
        if scene.solver.in_volumes:
            self.grown = self._grown(facts)
            self.particles = {kind: int(self.grown * facts.solver.particles.count) for kind in kinds[:1]}
        self.n = sum(self.particles.values())
        work = workload(facts.solver)
        self.step_load = costs.StepLoad(
            self.particles, work.blocks, work.node_blocks, work.contact_blocks, work.surfaces, work.moving,
            len(facts.model.obstacles), scene.initial.stress == "settle" or bool(scene.saw_test), work.components)
        self._shortened = work.shortened
        self.frames = max(1, round((facts.end - facts.begin) / scene.output.interval))
        usual = OF_SAW_TESTS if scene.saw_test else SETTLING_STEPS
        self.settling_steps = usual if scene.initial.stress == "settle" else 0
        self.numbers = sum(width(name) for name in written_fields(scene))
        # A step with little work runs on one thread
        self.threads = 1 if work.serial else threads
        reference = Speed(*costs.reference_speed())
        self._vector, self._python = speed.over(reference) if speed else (1.0, 1.0)

    @staticmethod
    def _grown(facts):
        """Cells with snow in the mean of a run over those of the release: 1 and half of the longest way over the side
        of a square as large as the release. Measured: 3.6 (this says 2.9) in the library's valley; with 1.5 m of snow
        and Coulomb friction 10.5 (8.5) on avaAlr, where it leaves threads, and about 5 (9) on a plane, where it leaves
        nothing behind."""
        course = facts.forecast.course
        side = facts.dx * facts.solver.particles.count ** 0.5
        return GROWN if course is None or not course.way else 1.0 + 0.5 * course.way / side

    def stages(self, scheme=None, particles=1.0, blocks=1.0, settling=False):
        """Seconds of the stages of a step on this machine, also of another scheme, or of a share of the particles and
        blocks."""
        found = costs.stages(scheme or self.scheme, self.step_load.times(particles, blocks), settling)
        shared = 1.0 + EFFICIENCY * (self.threads - 1)
        slower = {name: self._python if name in PYTHON or (name in COMPONENTS and COMPONENTS[name].in_python)
                  else self._vector for name in found}
        return {name: slower[name] * seconds / (shared if name in PARALLEL else 1.0) for name, seconds in found.items()}

    def step(self, scheme=None, particles=1.0, blocks=1.0):
        """Seconds of a step."""
        return sum(self.stages(scheme, particles, blocks).values())

    @property
    def stepping(self):
        """Seconds of all steps."""
        return self.facts.steps * self.step()

    @property
    def settling(self):
        """Seconds of the steps before the clock starts."""
        return self.settling_steps * sum(self.stages(settling=True).values())

    @property
    def output(self):
        """Seconds of all frames."""
        return self.frames_at(1.0)

    def frames_at(self, particles):
        """Seconds of all frames with the number of particles multiplied by this factor."""
        one = costs.frame(particles * self.n, self.numbers, self.scheme, self.step_load.obstacles)
        return self._python * self.frames * one

    @property
    def start(self):
        """Seconds until the first step, with kernels from the cache."""
        return self._python * costs.start(self.facts.dim, self.n)

    @property
    def run_file(self):
        """Expected size of the run file [bytes]."""
        return expected_run_file(self.facts.scene, self.n)

    @property
    def total(self):
        """Seconds of the run."""
        return self.start + self.settling + self.stepping + self.output

    def payments(self):
        """`Payment`s of the scene, as a table."""
        facts, scheme, steps, step_load = self.facts, self.scheme, self.facts.steps, self.step_load
        stages = {name: steps * seconds for name, seconds in self.stages().items()}
        sizes = facts.solver.particles.sizes
        a_cell = facts.scene.solver.filling
        usual = costs.usual_law(scheme)
        # Each law takes its share of the particles' time from the table
        in_table = {kind: n * (costs.law(scheme, kind) + usual) for kind, n in self.particles.items()}
        rest = self.n * (costs.transfers(scheme) - usual)
        entry, pieces = METHODS[scheme.method], facts.scene.solver.pieces
        scale = stages["particles"] / (rest + sum(in_table.values()))
        rows = [("dimension", f"{facts.dim}-D, {self.n} {pieces}, {a_cell} a cell, {entry.title}", scale * rest)]
        if facts.scene.solver.in_volumes:
            rows = [(pieces, f"{self.n} with snow in the mean, {self.grown:.2g} times those of the release",
                     stages["particles"])]
        elif entry.capabilities.plan:
            rows = [(pieces, f"{self.n}, {a_cell} a cell in plan", stages["particles"])]
        else:
            rows += [(f"law {kind}", f"{self.particles[kind]} particles", scale * ns) for kind, ns in in_table.items()]
        if entry.capabilities.grid and not entry.capabilities.solves:
            a_block = self.n / max(1, step_load.blocks)
            rows.append(("blocks of the grid", f"{step_load.blocks}, {a_block:.0f} particles in each",
                         stages["blocks"] + stages["nodes"]))
            near = f"{step_load.contact_blocks} blocks near {step_load.surfaces} surfaces"
            rows.append(("contact", near, stages["contact"]))
            rows.append(("sorts", "particles that change their blocks", stages["sorts"]))
        for name, work in step_load.components.items():
            if not work:
                continue
            counts = ", ".join(f"{n} {what}s" for what, n in work.items()
                               if n and not costs.once(what, n) and not what.startswith("followed"))
            shorter = self._shortened.get(name, 1.0)
            rows.append((COMPONENTS[name].words, counts + (
                f", steps {shorter:.2f} times as long as without" if shorter < 0.995 else ""), stages[name]))
        rows.append(("calls of kernels", f"{steps:.0f} steps", stages["calls"]))
        if self.settling_steps:
            rows.append(("settling", f"about {self.settling_steps} steps before the clock starts", self.settling))
        rows.append(("output", f"{self.frames} frames of {self.numbers + 3} numbers a {pieces[:-1]}",
                     self.output))
        rows.append(("start", "imports, build, kernels from the disk; the first time they are compiled", self.start))
        found = [Payment(*row, row[2] / self.total) for row in rows]
        carried = ", ".join(name.replace("_", " ") for name, size in sizes.items() if size)
        size = facts.solver.particles.bytes_per_particle
        found.append(Payment("precision", f"{scheme.precision}, {size} B a particle ({carried})", None, None))
        if scheme.lengths != "constant":
            times = costs.transfers(scheme) / costs.transfers(replace(scheme, lengths="constant"))
            found.append(Payment("smoothing lengths", f"{scheme.lengths}: {times:.1f} times the cost of constant ones,"
                                                      " and steps half as long", None, None))
        fields = int(facts.model.population.field.max()) + 1
        if fields > 1:
            found.append(Payment("velocity fields", f"{fields}: nodes of touching bodies are kept once for each", None,
                                 None))
        return found


def width(field):
    """Numbers that a field of the run file has a particle."""
    return {"velocity": 3, "stress": 6}.get(field, 1)
