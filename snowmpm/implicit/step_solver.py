"""One step of particles, solved for, in as many parts as it takes.

    quasi_static   R(u) = 0 at the loads of the end of the step. What is out of balance at its start is applied in parts
                   where it cannot be applied at once.
    newmark        the same with inertia (`newmark`), of shorter steps where a step cannot be solved.

Particles keep their place in the cells until a part is solved, and then move by sum_I w u_I. Their velocity becomes
P v_p + gain (pic, apic), P the best fit to it that the nodes can carry and gain what the nodes gain, or P v_p + gain +
flip_ratio (v_p - P v_p) (flip, aflip). There is no other smoothing: where apic of explicit MPM loses what its lumped
mass smooths, this does not.
"""

from dataclasses import dataclass, field

import numpy as np

from snowmpm.errors import SimulationError
from snowmpm.implicit.balance import Balance
from snowmpm.implicit.contact_set import ContactSet
from snowmpm.implicit.linear import Linear
from snowmpm.implicit.mesh import Mesh
from snowmpm.implicit.newmark import Newmark, Projection
from snowmpm.implicit.newton import NotConverged, solve
from snowmpm.stepping.contact_velocity import SEPARATE

SMALLEST_PART = 1.0 / 1024.0
"""Of a step, or of what is out of balance, before it is given up."""

ENTERED = 0.25
"""Cells that a step may carry snow into a surface that it did not touch at its start."""


@dataclass
class Grid:
    """dx [m], origin [m], kernel, gradient, surfaces (`surfaces.Surface`); extended: faint nodes follow others; period
    (dim,): cells after which axes repeat, None where none does."""

    dx: float
    origin: np.ndarray
    kernel: str
    gradient: str
    surfaces: list
    extended: bool = True
    period: np.ndarray | None = None

    @property
    def parting(self):
        """Surfaces that snow may leave, and come to."""
        return [surface for surface in self.surfaces if surface.code == SEPARATE]


@dataclass
class Rules:
    """time: "newmark" or "quasi_static"; tolerance of |R| over the forces; most iterations; linear: kind of solver;
    damping of Newmark's rule; flip: share of the particles' own velocity that stays."""

    time: str = "newmark"
    tolerance: float = 1e-9
    iterations: int = 20
    linear: str = "auto"
    damping: float = 0.0
    flip: float = 0.0


@dataclass
class StepResult:
    """What a step did. impulse of surfaces [N s]; force of surfaces at its end [N]; plastic work [J]; yielding,
    unconverged: particles; parts: solved; residuals of the last part; rubbed: energy that friction took [J]; given:
    impulse and moment that obstacles got, pressing: force and moment on them at the end (`ContactSet.on_obstacles`);
    lines: that touch, spared: settled by a rule (`ContactSet.counts`), of all parts; loaded: impulse on surfaces of
    bodies."""

    impulse: np.ndarray
    force: np.ndarray
    work: float = 0.0
    yielding: int = 0
    unconverged: int = 0
    parts: int = 0
    iterations: int = 0
    residuals: list = field(default_factory=list)
    rubbed: float = 0.0
    given: np.ndarray | float = 0.0
    pressing: np.ndarray | float = 0.0
    lines: int = 0
    spared: int = 0
    loaded: np.ndarray | float = 0.0

    def count(self, touch):
        """Add the lines of a part's `ContactSet`."""
        lines, spared = touch.counts()
        self.lines, self.spared = self.lines + lines, self.spared + spared


class StepSolver:
    """Steps of a `MaterialPoints` on a `Grid` by `Rules`. materials: `MaterialTable` of float64."""

    def __init__(self, grid, rules, materials):
        self.grid, self.rules, self.materials = grid, rules, materials

    def touch(self, matter):
        """`ContactSet` of particles where they are."""
        grid = self.grid
        mesh = Mesh(matter.cells, grid.dx, grid.kernel, grid.gradient, grid.period)
        filled = matter.volume * matter.ratio / grid.dx**mesh.dim
        return ContactSet(mesh, grid.surfaces, grid.kernel, filled, grid.extended)

    def mesh(self, matter):
        """`Mesh` and `Held` of particles where they are."""
        touch = self.touch(matter)
        return touch.mesh, touch.smooth()

    # ---- at rest ----------------------------------------------------------------------------------------------------

    def to_balance(self, matter, body, dt):
        """Bring particles to rest under b (n, dim) [m/s2], which took dt [s]; -> `StepResult`.

        Raises SimulationError when nothing holds them.
        """
        passed = StepResult(*np.zeros((2, matter.cells.shape[1])))
        share = 1.0
        while True:
            touch = self.touch(matter)
            setting = (matter, self.materials, body, self.grid.dx, dt, 0.0, None)
            try:
                solved, held = self._balanced(touch, setting, 1.0 - share)
                self._refuse_entry(matter, touch.mesh.W @ solved.trial.u)
            except NotConverged as error:
                share *= 0.5
                if share < SMALLEST_PART:
                    raise SimulationError(self._why(error, "the loads")) from error
                continue
            self._book(passed, matter, solved)
            for term in matter.terms:
                passed.loaded += term.carry(solved.trial.u, 0.0, dt if share == 1.0 else 0.0)
            matter.cells += touch.mesh.W @ solved.trial.u / self.grid.dx
            matter.velocity[:] = 0.0
            matter.affine[:] = 0.0
            passed.force = self._force(held, solved.trial)
            if touch.changes:
                passed.count(touch)
                passed.rubbed += touch.taken(solved.trial)
                passed.pressing = touch.on_obstacles(solved.trial.full, self.grid.dx)
            if share == 1.0:
                break
            share = min(1.0, 2.0 * share)
        passed.impulse, passed.given = dt * passed.force, dt * passed.pressing
        return passed

    def _balanced(self, touch, setting, left):
        """`Solved` of the equations `Balance(mesh, held, *setting)` without the share `left` of the loads, and the
        `Held` of the contact that goes with it."""
        mesh = touch.mesh
        if not touch.changes:
            held = touch.smooth()
            return solve(Balance(mesh, held, *setting), self._linear(held), self.rules.tolerance,
                         self.rules.iterations, left), held
        lessened = np.zeros((mesh.n_nodes, mesh.dim))
        if left:  # the forces of surfaces are sought, and are not loads
            held = touch.smooth()
            lessened = left * Balance(mesh, held, *setting).at(np.zeros(held.T.shape[1])).full
            lessened[touch.nodes | held.touched] = 0.0
        return self._in_contact(touch, setting, lessened, np.zeros((mesh.n_nodes, mesh.dim)))

    def _in_contact(self, touch, setting, lessened, start, past=None):
        """`Solved` from displacements start (N, dim) with states of the contact that agree with it, and its `Held`.
        lessened (N, dim): loads of the nodes that do not act yet [N]; past: of `ContactSet.held`."""
        while True:
            held = touch.held(past)
            balance = Balance(touch.mesh, held, *setting)
            balance.external = balance.external + lessened
            solved = solve(balance, self._linear(held), self.rules.tolerance, self.rules.iterations,
                           start=start.ravel()[held.free])
            if touch.settle(solved.trial, past):
                return solved, held
            start = solved.trial.u

    def _linear(self, held):
        return Linear(held.T, held.mesh.dim, self.rules.linear, held.test)

    def _refuse_entry(self, matter, way):
        """Raise NotConverged where way (n, dim) [m] carries particles into a surface that they were not in."""
        for surface in self.grid.parting:
            before = np.minimum(surface.distance(matter.cells)[0], 0.0)
            into = before - surface.distance(matter.cells + way / self.grid.dx)[0]
            if (into > ENTERED).any():
                raise NotConverged("snow came into a surface that it did not touch", node=matter.cells[into.argmax()])

    def _force(self, held, trial):
        """Force of the surfaces at rest [N] (dim,): none where it is within what Newton's method leaves."""
        force = trial.full[held.touched].sum(axis=0)
        return force if np.linalg.norm(force) > self.rules.tolerance * trial.scale + trial.noise else 0.0 * force

    def _why(self, error, what):
        place = ""
        if error.node is not None:
            at = self.grid.origin + self.grid.dx * np.asarray(error.node)
            place = f", worst near {np.array2string(at, precision=3)} m"
        return f"the step was not solved, with 1/{round(1.0 / SMALLEST_PART)} of {what} either: {error}{place}"

    def _book(self, passed, matter, solved):
        after = solved.trial.after
        passed.work += float(matter.volume @ after.work)
        passed.yielding = int((after.iterations > 0).sum())
        passed.unconverged += int((after.iterations < 0).sum())
        passed.parts += 1
        passed.iterations += len(solved.residuals) - 1
        passed.residuals = solved.residuals
        matter.take(after)

    # ---- in time ----------------------------------------------------------------------------------------------------

    def in_time(self, matter, acceleration, body, dt, starts, pressing=0.0):
        """Advance particles by dt [s]; -> `StepResult`.

        acceleration (n, dim): of stress and surfaces at the start, becomes that of the end; body (n, dim): b; starts:
        nobody knows that acceleration; pressing: force and moment on obstacles at the start. Raises SimulationError.
        """
        loads = sum(term.force for term in matter.terms)
        passed = StepResult(np.zeros(matter.cells.shape[1]), matter.mass @ acceleration - loads, pressing=pressing)
        done, part = 0.0, 1.0
        while done < 1.0:
            part = min(part, 1.0 - done)
            try:
                self._one(matter, acceleration, body, Newmark(part * dt, self.rules.damping, starts), passed)
            except NotConverged as error:
                part *= 0.5
                if part < SMALLEST_PART:
                    raise SimulationError(self._why(error, "its time")) from error
                continue
            starts = False
            done += part
            part *= 2.0
        return passed

    def _one(self, matter, acceleration, body, rule, passed):
        """A part by a `Newmark` rule. Changes nothing when it fails."""
        touch = self.touch(matter)
        mesh, dt, mass = touch.mesh, rule.dt, matter.mass[:, None]
        held = touch.smooth()
        projection = Projection(mesh, held, matter.mass)
        v0, free, lost_momentum = projection.at_particles(matter.velocity)
        if touch.changes:
            held = touch.smooth(held.full(free))
            projection = Projection(mesh, held, matter.mass)
            v0, free, lost_momentum = projection.at_particles(matter.velocity)
        a0, a0_free, lost_force = projection.at_particles(acceleration + body)
        history = mesh.W.T @ (mass * rule.past(v0, a0))
        setting = (matter, self.materials, body, self.grid.dx, dt, rule.inertia, history)
        if touch.changes:
            first, past = held, rule.at_rest(held.full(free), held.full(a0_free))
            lost = [touch.on_obstacles(each, self.grid.dx, rubbing=False) for each in (lost_momentum, lost_force)]
            solved, held = self._in_contact(touch, setting, 0.0, dt * first.full(free), past)
            taken = first.touched
        else:
            solved, taken = self._solved(matter, (mesh, held, *setting), dt, dt * free), held.touched
        u = solved.trial.u
        way = mesh.W @ u
        self._refuse_entry(matter, way)
        a1 = rule.acceleration(way, v0, a0)
        own = matter.velocity - v0
        matter.velocity = v0 + rule.gain(a0, a1) + self.rules.flip * own
        matter.cells += way / self.grid.dx
        matter.affine = mesh.gradient_of(u) / dt
        acceleration[:] = a1 - body
        kept = 1.0 - self.rules.flip
        force = solved.trial.full[held.touched].sum(axis=0)
        passed.impulse += dt * ((1.0 - rule.gamma) * (passed.force + lost_force[taken].sum(axis=0))
                                + rule.gamma * force)
        passed.impulse += kept * lost_momentum[taken].sum(axis=0)
        passed.force = force
        for term in matter.terms:
            passed.loaded += term.carry(u, (1.0 - rule.gamma) * dt, rule.gamma * dt)
        if touch.changes:
            passed.count(touch)
            passed.rubbed += touch.taken(solved.trial)
            pressing = touch.on_obstacles(solved.trial.full, self.grid.dx)
            passed.given += kept * lost[0] + dt * ((1.0 - rule.gamma) * (passed.pressing + lost[1])
                                                   + rule.gamma * pressing)
            passed.pressing = pressing
        self._book(passed, matter, solved)

    def _solved(self, matter, setting, dt, start):
        """`Solved` of the equations `Balance(*setting)` of a step of dt [s], from displacements start (free,)."""
        return solve(Balance(*setting), self._linear(setting[1]), self.rules.tolerance, self.rules.iterations,
                     start=start)
