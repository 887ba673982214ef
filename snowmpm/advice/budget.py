"""What a scene pays for: its expected run time, by parts, from costs that were measured."""

from dataclasses import dataclass

import numpy as np

from snowmpm import costs


@dataclass(frozen=True)
class Payment:
    """One thing that a scene pays for: `what`, in words; seconds of the run, share of it."""

    what: str
    detail: str
    seconds: float | None
    share: float | None


class Budget:
    """Expected run time of a scene (`SceneFacts`), by its parts."""

    def __init__(self, facts):
        self.facts, scene = facts, facts.scene
        self.scheme = costs.Scheme.of(scene)
        kinds = list(dict.fromkeys(law.kind for law in facts.model.laws))
        counts = np.bincount(facts.model.population.material, minlength=len(facts.model.laws))
        self.particles = {kind: int(sum(n for n, law in zip(counts, facts.model.laws, strict=True) if law.kind == kind))
                          for kind in kinds}
        self.n = sum(self.particles.values())
        self.blocks = len(facts.solver.particles.blocks)
        self.frames = max(1, round(scene.end_time / scene.output.interval))
        self.numbers = sum(width(name) for name in scene.output.fields)

    def step(self, scheme=None, particles=1.0, blocks=1.0):
        """Seconds of a step, also of another scheme, or of a share of the particles and blocks."""
        counts = [particles * n for n in self.particles.values()]
        return costs.step(scheme or self.scheme, counts, blocks * self.blocks, list(self.particles))

    @property
    def stepping(self):
        """Seconds of all steps."""
        return self.facts.steps * self.step()

    @property
    def output(self):
        """Seconds of all frames."""
        return self.frames * costs.frame(self.n, self.numbers, self.facts.dim)

    @property
    def total(self):
        """Seconds of the run."""
        return self.stepping + self.output

    def payments(self):
        """`Payment`s of the scene, as a table."""
        facts, scheme, steps = self.facts, self.scheme, self.facts.steps
        sizes = facts.solver.particles.layout.sizes
        a_cell = facts.scene.solver.filling
        usual = costs.usual_law(scheme)
        rows = [("dimension", f"{facts.dim}-D, {self.n} particles, {a_cell} a cell, {scheme.method}",
                 steps * 1e-9 * self.n * (costs.transfers(scheme) - usual))]
        rows += [(f"law {kind}", f"{n} particles", steps * 1e-9 * n * (costs.law(scheme, kind) + usual))
                 for kind, n in self.particles.items()]
        if scheme.method == "mpm":
            rows.append(("blocks of the grid", f"{self.blocks}, {self.n / max(1, self.blocks):.0f} particles in each",
                         steps * 1e-9 * self.blocks * costs.block(scheme)))
        rows.append(("calls of kernels", f"{steps:.0f} steps", steps * costs.call(scheme)))
        rows.append(("output", f"{self.frames} frames of {self.numbers + 3} numbers a particle", self.output))
        found = [Payment(*row, row[2] / self.total) for row in rows]
        carried = ", ".join(name.replace("_", " ") for name, size in sizes.items() if size)
        size = facts.solver.particles.bytes_per_particle
        found.append(Payment("precision", f"{scheme.precision}, {size} B a particle ({carried})", None, None))
        fields = int(facts.model.population.field.max()) + 1
        if fields > 1:
            found.append(Payment("velocity fields", f"{fields}: nodes of touching bodies are kept once for each", None,
                                 None))
        return found


def width(field):
    """Numbers that a field of the run file has a particle."""
    return {"velocity": 3, "stress": 6}.get(field, 1)
