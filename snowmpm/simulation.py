"""A simulation, step by step."""

import copy
import math

import numpy as np

from snowmpm.build import build
from snowmpm.diagnostics import Audit
from snowmpm.errors import InputError, SimulationError
from snowmpm.failure import likeness
from snowmpm.fields import ParticleFields
from snowmpm.saw_test.crack import CrackRecord
from snowmpm.settling import settle
from snowmpm.step_check import check_step, rounded_down

COLLAPSE = 1e-5
"""Share of the first time step below which a run comes to no end, but to nonsense."""


class Simulation:
    """A scene in motion.

        sim = Simulation(scene)
        while sim.time < 1.0:
            sim.step()
        sim.particles["velocity"]

    time [s]; dt [s] and dt_cause of the last step: "elastic", "advective", "deformation", "fixed" or "output" (cut to
    land on a time asked for); particles[name]: NumPy copies (`snowmpm.fields.ParticleFields`).
    Raises InputError for a scene that cannot be built, SimulationError when a step fails.
    """

    def __init__(self, scene, settled=False):
        """settled: the state comes from a checkpoint, so an initial stress "settle" is not relaxed once more."""
        self.scene = scene
        self.model = build(scene)
        self.solver = self.model.solver()
        self.events = self.model.events()
        self.dt, self.dt_cause, self._first_dt = 0.0, "elastic", None
        check_step(scene, self.solver)
        if scene.initial.stress == "settle" and not settled:
            self.settle()
        self.crack = CrackRecord(self, self.events[-1]) if scene.saw_test else None
        """What a saw test measures (`snowmpm.saw_test.crack`); None without one."""
        self._audit = Audit(self.solver, self.particles, self.model.direction, self.model.population.positions)

    @property
    def time(self):
        return self.solver.time

    @property
    def n_particles(self):
        """Particles that are in the domain now."""
        return self.solver.particles.count

    @property
    def max_speed(self):
        """Largest particle speed after the last step [m/s]."""
        return self.solver.extremes.speed

    @property
    def particles(self):
        return ParticleFields(self.solver.particles, self.model.body_starts)

    def law_of_body(self, body):
        """Law of the body with this index, as this grid has it."""
        return self.model.laws[list(self.scene.materials).index(self.scene.bodies[body].material)]

    def numbers_of_body(self, body):
        """First particle number of a body, and one past its last."""
        ends = [*self.model.body_starts, len(self.model.population.volumes)]
        return int(ends[body]), int(ends[body + 1])

    def step(self, until=None):
        """Advance by one step: the largest stable one, shortened so that whole steps land on `until` [s]."""
        for event in self.events:
            if not event.done:
                event.apply(self)
        dt, cause = self._next_step()
        if until is not None and until > self.time:
            n = math.ceil((until - self.time) / dt * (1.0 - 1e-9))
            if n <= 1:
                dt, cause = until - self.time, "output" if until - self.time < 0.99 * dt else cause
            else:
                dt = (until - self.time) / n
        try:
            self.solver.step(dt)
        except SimulationError as error:
            known = likeness(self.scene.solver, self.solver, dt)
            # In two lines: what is known of such a failure says more than what helps in general
            raise SimulationError(f"{str(error).splitlines()[0]}\n{known}" if known else str(error)) from error
        if until is not None and abs(until - self.time) < 1e-9 * max(1.0, until):
            self.solver.time = until
        self.dt, self.dt_cause = dt, cause
        if self.crack:
            self.crack.watch()

    def audit(self, particles=None):
        """One row of the history: conserved quantities, energies, front, counters (`snowmpm.diagnostics`)."""
        return {**self._audit.values(particles or self.particles), "dt": self.dt}

    def follow_loads(self):
        """Hand the loads of all events to the solver, in the order of the scene."""
        self.solver.set_loads([event.load for event in self.events if event.load is not None])

    def state(self):
        """All that a bitwise continuation needs, by name (`snowmpm.checkpoint`): copies, also while it goes on."""
        rest = {"events": [event.state() for event in self.events], "audit": self._audit.state(),
                "body_starts": self.model.body_starts, "dt": self.dt, "dt_cause": self.dt_cause,
                "crack": self.crack.state() if self.crack else {}}
        return {"solver": self.solver.state(), **copy.deepcopy(rest)}

    def restore(self, state):
        """Take over the `state()` of a simulation of the same scene. Raises InputError when it does not fit."""
        if not np.array_equal(state["body_starts"], self.model.body_starts):
            raise InputError(f"{self.scene.source}: bodies: not as many particles as when the run began")
        self.solver.restore(state["solver"])
        for event, own in zip(self.events, state["events"], strict=True):
            event.restore(own)
        self.follow_loads()
        self._audit.restore(state["audit"])
        if self.crack:
            self.crack.restore(state["crack"])
        self.dt, self.dt_cause = state["dt"], state["dt_cause"]

    def _next_step(self):
        fixed = self.scene.solver.dt
        if fixed:
            limit, cause = self.solver.critical_dt()
            if fixed > limit:
                raise SimulationError(f"solver.dt = {fixed:g} s is too long at t = {self.time:.6g} s: the {cause} limit"
                                      f" is {rounded_down(limit)} s; leave solver.dt out for an adaptive step")
            return fixed, "fixed"
        dt, cause = self.solver.stable_dt()
        self._first_dt = self._first_dt or dt
        if not dt > COLLAPSE * self._first_dt:
            raise SimulationError(f"the time step fell to {dt:.3g} s at t = {self.time:.6g} s, by the {cause} limit,"
                                  f" from {self._first_dt:.3g} s at the start:\nthe snow moves faster, or is stiffer,"
                                  " than anything real; lower solver.cfl or check the material")
        return dt, cause

    def settle(self):
        """Relax to rest under gravity (`snowmpm.settling`). Raises SimulationError when it does not settle."""
        wanted = self.scene.initial.tolerance
        rest = settle(self.solver, wanted, max(self.model.depth, self.scene.solver.dx))
        if not rest.settled:
            raise SimulationError(f"{self.scene.source}: initial.stress = \"settle\": not at rest after {rest.steps}"
                                  f" steps: speed {rest.speed:.2g} sqrt(g D), imbalance {rest.imbalance:.2g} of the"
                                  f" weight, initial.tolerance = {wanted:g};\nthe scene is not stable before its"
                                  " trigger, or wants a larger tolerance")
