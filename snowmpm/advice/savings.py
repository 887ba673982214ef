"""No more than a scene needs: what it pays for, and what it could do without."""

from dataclasses import dataclass, replace

import numpy as np

from snowmpm import costs
from snowmpm.borders import shipped
from snowmpm.timestep import usual_cfl

WORTH_SAYING = 0.05
"""Share of the run time below which a saving is not mentioned."""
ALIKE = 0.02
"""Share of the cells of a cross-section that may differ in plane strain."""
SPARE_DOMAIN = 1.5
"""How much longer than what can be reached a side of the domain may be before it is mentioned."""


@dataclass(frozen=True)
class Payment:
    """One thing that a scene pays for: `what`, in words; seconds of the run, share of it."""

    what: str
    detail: str
    seconds: float | None
    share: float | None


@dataclass(frozen=True)
class Saving:
    """What a scene could do without: key and setting that leave it out; seconds and share of the run saved."""

    key: str
    says: str
    seconds: float
    share: float


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
        self.numbers = sum(width(name, scene.dimension) for name in scene.output.fields)

    def step(self, scheme=None, particles=1.0, blocks=1.0):
        """Seconds of a step, also of another scheme, or of a share of the particles and blocks."""
        counts = [particles * n for n in self.particles.values()]
        return costs.step(scheme or self.scheme, counts, blocks * self.blocks, list(self.particles))

    @property
    def steps(self):
        return self.facts.steps * self.step()

    @property
    def output(self):
        return self.frames * costs.frame(self.n, self.numbers, self.facts.dim)

    @property
    def total(self):
        return self.steps + self.output

    def payments(self):
        """`Payment`s of the scene, as a table."""
        facts, scheme, steps = self.facts, self.scheme, self.facts.steps
        sizes = facts.solver.particles.layout.sizes
        a_cell = facts.scene.solver.filling
        rows = [("dimension", f"{facts.dim}-D, {self.n} particles, {a_cell} a cell, {scheme.method}",
                 steps * 1e-9 * self.n * costs.transfers(scheme))]
        rows += [(f"law {kind}", f"{n} particles",
                  steps * 1e-9 * n * (costs.law(scheme, kind) + costs.table()["law", facts.dim, scheme.precision,
                                                                              costs.USUAL_LAW]))
                 for kind, n in self.particles.items()]
        usual = 1e-9 * self.n * costs.table()["law", facts.dim, scheme.precision, costs.USUAL_LAW]
        rows[0] = (*rows[0][:2], rows[0][2] - steps * usual)
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

    def savings(self):
        """`Saving`s of the scene, the largest first."""
        found = [saving for find in (self._plane, self._double, self._frames, self._spline, self._crowded, self._short,
                                     self._stiff, self._domain, self._return_maps) for saving in find()]
        return sorted(found, key=lambda saving: -saving.seconds)

    def _saving(self, key, says, seconds):
        if seconds > WORTH_SAYING * self.total:
            yield Saving(key, says, seconds, seconds / self.total)

    def _plane(self):
        facts = self.facts
        if facts.dim == 3 and is_plane_strain(facts):
            per_axis = facts.per_axis
            deep = max(1.0, np.ptp(facts.model.population.positions[:, 1]) / facts.dx * per_axis + 1.0)
            scheme = replace(self.scheme, dimension=2)
            counts = [n / deep for n in self.particles.values()]
            step = costs.step(scheme, counts, self.blocks * 4.0 / (deep / per_axis) / 4.0, list(self.particles))
            saved = self.total - facts.steps * step - self.output / deep
            yield from self._saving("dimension", "2: nothing of it changes along y, it is plane strain", saved)

    def _double(self):
        if self.scheme.precision != "f64":
            return
        border = shipped()["small_strains", "f32"]
        if border.failing(self.facts.least_strain):
            return
        saved = self.facts.steps * (self.step() - self.step(replace(self.scheme, precision="f32")))
        limit = f"float32 holds to {border.value:.1g}" if border.value else "float32 holds them"
        yield from self._saving("solver.precision", f'"f32": elastic strains are about {self.facts.least_strain:.1g},'
                                f" and {limit} (atlas: small_strains)", saved)

    def _frames(self):
        """Where frames take a fifth of the run: so many that they take a tenth."""
        if self.output > 0.2 * self.total:
            factor = 9.0 * self.output / self.steps
            interval = float(f"{self.facts.scene.output.interval * factor:.1g}")
            saved = self.output * (1.0 - self.facts.scene.output.interval / interval)
            yield from self._saving("output.interval", f"{interval:g} s: frames take {self.output / self.total:.0%} of"
                                    f" the run, {self.frames} of them", saved)

    def _spline(self):
        if self.scheme.method == "mpm" and self.scheme.kernel == "cubic":
            saved = self.facts.steps * (self.step() - self.step(replace(self.scheme, kernel="quadratic")))
            yield from self._saving("solver.kernel", '"quadratic": cubic is needed only where bodies are stretched to'
                                    " twice their length, or bend far", saved)

    def _crowded(self):
        usual = 4 if self.facts.dim == 2 else 8
        crowd = self.facts.scene.solver.particles_per_cell
        if self.scheme.method == "mpm" and crowd > usual:
            share = usual / crowd
            saved = self.facts.steps * (self.step() - self.step(particles=share)) + (1.0 - share) * self.output
            yield from self._saving("solver.particles_per_cell", f"{usual}: more are needed only where bodies are"
                                    " stretched to twice their length", saved)

    def _short(self):
        """A cfl or dt below the usual one."""
        scene, solver = self.facts.scene, self.facts.solver
        usual = usual_cfl(solver.critical_cfl)
        own = scene.solver.cfl
        if scene.solver.dt:
            own = usual * scene.solver.dt / (solver.critical_dt()[0] * usual / solver.critical_cfl)
        if own and own < 0.8 * usual:
            key = "solver.dt" if scene.solver.dt else "solver.cfl"
            yield from self._saving(key, f"leave it out: {own:.2g} of a cell a step where {usual:.2g} is stable and"
                                    " usual", self.steps * (1.0 - own / usual))

    def _stiff(self):
        """One material that alone sets the step."""
        if self.facts.scene.solver.dt:
            return
        speeds = {name: law.wave_speed() for name, law in zip(self.facts.scene.materials, self.facts.model.laws,
                                                              strict=True)}
        fastest = max(speeds, key=speeds.get)
        rest = max((speed for name, speed in speeds.items() if name != fastest), default=speeds[fastest])
        if speeds[fastest] > 2.0 * rest:
            soft = (speeds[fastest] / rest) ** 2
            yield from self._saving(f"materials.{fastest}.youngs_modulus", f"its waves alone set the step; {soft:.0f}"
                                    " times softer it would be as fast as the rest, if its deformation does not matter",
                                    self.steps * (1.0 - rest / speeds[fastest]))

    def _domain(self):
        """A domain larger than what can be reached costs memory, not time: blocks follow the snow."""
        scene = self.facts.scene
        if not scene.domain or scene.domain.min is None or self.facts.model.surface is not None:
            return
        x = self.facts.model.population.positions
        way = max(self.facts.start_speed, self.facts.fall_speed) * scene.end_time
        for a, axis in enumerate("xz" if self.facts.dim == 2 else "xyz"):
            reach = np.ptp(x[:, a]) + 2.0 * way
            length = self.facts.model.upper[a] - self.facts.model.lower[a]
            if length > SPARE_DOMAIN * reach:
                yield Saving("domain", f"{length:.3g} m along {axis}, of which {reach:.3g} m can be reached: the rest"
                             " costs nothing, blocks of the grid follow the snow", 0.0, 0.0)

    def _return_maps(self):
        """A return map that is more accurate than the step it is used with."""
        for name, law in zip(self.facts.scene.materials, self.facts.model.laws, strict=True):
            if getattr(law, "return_map", None) == "substepped":
                kind = f"{law.kind}, substepped"
                more = costs.law(self.scheme, kind) - costs.law(self.scheme, law.kind)
                yield from self._saving(f"materials.{name}.return_map", '"implicit": sub-stepping pays where a step'
                                        " strains by a thousandth or more (atlas: apex)",
                                        self.facts.steps * 1e-9 * self.particles[law.kind] * more)


def width(field, dim):
    """Numbers that a field of the run file has a particle."""
    return {"velocity": 3, "stress": 6}.get(field, 1)


def is_plane_strain(facts):
    """Whether nothing of a 3-D scene changes along y: each slice of cells looks alike, the ground and the obstacles are
    drawn out, nothing moves along y, and the ends are such that nothing can."""
    scene = facts.scene
    if scene.domain is None or scene.saw_test:
        return False
    sides = scene.domain.sides(3)
    smooth = {"periodic", "slip", "symmetric"}
    if sides["y_min"] not in smooth or sides["y_max"] not in smooth:
        return False
    if scene.gravity_vector[1] or np.abs(facts.model.population.velocities[:, 1]).max(initial=0.0) > 0.0:
        return False
    if scene.events or any(not _drawn_out(obstacle, facts) for obstacle in scene.obstacles):
        return False
    across = facts.model.population.positions[:, 1]
    if across.min() > facts.model.lower[1] + facts.dx or across.max() < facts.model.upper[1] - facts.dx:
        return False
    cells = np.floor(facts.model.population.positions / facts.dx).astype(np.int64)
    rows = np.unique(cells[:, 1])
    sections = [set(map(tuple, cells[cells[:, 1] == row][:, [0, 2]])) for row in rows]
    whole = set().union(*sections)
    if max(len(whole - section) for section in sections) > ALIKE * len(whole):
        return False
    surface = facts.model.surface
    if surface is None:
        return True
    lower, upper = facts.model.lower, facts.model.upper
    x = np.linspace(lower[0], upper[0], 41)[1:-1]
    lines = np.linspace(lower[1], upper[1], 7)[1:-1]
    heights = [surface.height(np.column_stack([x, np.full_like(x, y)])) for y in lines]
    spread = np.nanmax(np.ptp(np.array(heights), axis=0), initial=0.0)
    return bool(spread < 0.01 * facts.dx)


def _drawn_out(obstacle, facts):
    if obstacle.shape.kind != "box" or (obstacle.motion and (obstacle.motion.velocity[1] or any(
            obstacle.motion.angular_velocity[axis] for axis in (0, 2)))):
        return False
    return obstacle.shape.min[1] <= facts.model.lower[1] and obstacle.shape.max[1] >= facts.model.upper[1]
