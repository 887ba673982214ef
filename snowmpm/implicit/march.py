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
from snowmpm.implicit.held import Held
from snowmpm.implicit.linear import Linear
from snowmpm.implicit.mesh import Mesh
from snowmpm.implicit.newmark import Newmark, Projection
from snowmpm.implicit.newton import NotConverged, solve

SMALLEST_PART = 1.0 / 1024.0
"""Of a step, or of what is out of balance, before it is given up."""


@dataclass
class Grid:
    """dx [m], origin [m], kernel, gradient, surfaces (`held.Held`); extended: faint nodes follow others; f_bar: of
    `balance.Balance`."""

    dx: float
    origin: np.ndarray
    kernel: str
    gradient: str
    surfaces: list
    extended: bool = True
    f_bar: bool = False


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
class Passed:
    """What a step did. impulse of surfaces [N s]; force of surfaces at its end [N]; plastic work [J]; yielding,
    unconverged: particles; parts: solved; residuals of the last part; bytes of the matrix."""

    impulse: np.ndarray
    force: np.ndarray
    work: float = 0.0
    yielding: int = 0
    unconverged: int = 0
    parts: int = 0
    iterations: int = 0
    residuals: list = field(default_factory=list)


class March:
    """Steps of a `Matter` on a `Grid` by `Rules`. materials: `MaterialTable` of float64."""

    def __init__(self, grid, rules, materials):
        self.grid, self.rules, self.materials = grid, rules, materials

    def mesh(self, matter):
        """`Mesh` and `Held` of particles where they are."""
        mesh = Mesh(matter.cells, self.grid.dx, self.grid.kernel, self.grid.gradient)
        filled = matter.volume * matter.ratio / self.grid.dx**mesh.dim
        return mesh, Held(mesh, self.grid.surfaces, self.grid.kernel, filled if self.grid.extended else None)

    # ---- at rest ----------------------------------------------------------------------------------------------------

    def to_balance(self, matter, body, dt):
        """Bring particles to rest under b (n, dim) [m/s2], which took dt [s]; -> `Passed`.

        Raises SimulationError when nothing holds them.
        """
        passed = Passed(*np.zeros((2, matter.cells.shape[1])))
        share = 1.0
        while True:
            mesh, held = self.mesh(matter)
            balance = Balance(mesh, held, matter, self.materials, body, self.grid.dx, dt, f_bar=self.grid.f_bar)
            linear = Linear(held.T, mesh.dim, self.rules.linear)
            try:
                solved = solve(balance, linear, self.rules.tolerance, self.rules.iterations, 1.0 - share)
            except NotConverged as error:
                share *= 0.5
                if share < SMALLEST_PART:
                    raise SimulationError(self._why(error, "the loads")) from error
                continue
            self._book(passed, matter, solved)
            matter.cells += mesh.W @ solved.trial.u / self.grid.dx
            matter.velocity[:] = 0.0
            matter.affine[:] = 0.0
            passed.force = self._force(held, solved.trial)
            if share == 1.0:
                break
            share = min(1.0, 2.0 * share)
        passed.impulse = dt * passed.force
        return passed

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

    def _solved(self, matter, setting, dt, start):
        """`Solved` of the equations `Balance(*setting)` of a step of dt [s], from displacements start (free,)."""
        mesh, held = setting[:2]
        return solve(Balance(*setting), Linear(held.T, mesh.dim, self.rules.linear), self.rules.tolerance,
                     self.rules.iterations, start=start)

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

    def in_time(self, matter, acceleration, body, dt, starts):
        """Advance particles by dt [s]; -> `Passed`.

        acceleration (n, dim): of stress and surfaces at the start, becomes that of the end; body (n, dim): b; starts:
        nobody knows that acceleration. Raises SimulationError.
        """
        passed = Passed(np.zeros(matter.cells.shape[1]), matter.mass @ acceleration)
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
        mesh, held = self.mesh(matter)
        dt, mass = rule.dt, matter.mass[:, None]
        projection = Projection(mesh, held, matter.mass)
        v0, free, lost_momentum = projection.at_particles(matter.velocity)
        a0, _, lost_force = projection.at_particles(acceleration + body)
        history = mesh.W.T @ (mass * rule.past(v0, a0))
        setting = (mesh, held, matter, self.materials, body, self.grid.dx, dt, rule.inertia, history,
                   self.grid.f_bar)
        solved = self._solved(matter, setting, dt, dt * free)
        u = solved.trial.u
        way = mesh.W @ u
        a1 = rule.acceleration(way, v0, a0)
        own = matter.velocity - v0
        matter.velocity = v0 + rule.gain(a0, a1) + self.rules.flip * own
        matter.cells += way / self.grid.dx
        matter.affine = mesh.gradient_of(u) / dt
        acceleration[:] = a1 - body
        touched = held.touched
        force = solved.trial.full[touched].sum(axis=0)
        passed.impulse += dt * ((1.0 - rule.gamma) * (passed.force + lost_force[touched].sum(axis=0))
                                + rule.gamma * force)
        passed.impulse += (1.0 - self.rules.flip) * lost_momentum[touched].sum(axis=0)
        passed.force = force
        self._book(passed, matter, solved)
