"""A simulation, step by step."""

import copy
import math
import warnings
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from snowmpm import components
from snowmpm.annotations import Floats, PathLike
from snowmpm.compiler import lifetime
from snowmpm.compiler.lifetime import in_turn
from snowmpm.compiler.settings import compiling
from snowmpm.errors import InputError, SimulationError
from snowmpm.glance import Glance, counted
from snowmpm.materials import Law
from snowmpm.particles.fields import ParticleFields
from snowmpm.quantities.motion import Motion
from snowmpm.reading.named_files import noting
from snowmpm.registry import resolved
from snowmpm.running.audit import Audit
from snowmpm.running.events import make_events
from snowmpm.running.failure import diagnose
from snowmpm.running.fall import fall_speed
from snowmpm.running.relay import HandOver, Relay
from snowmpm.saw_test.crack import CrackRecord
from snowmpm.saw_test.strength import overloaded
from snowmpm.scenes.schema import Scene
from snowmpm.scenes.stop import rests_until
from snowmpm.setup.build import build
from snowmpm.setup.input_files import digests
from snowmpm.setup.mass_at_start import mass_doubts
from snowmpm.setup.model import Model
from snowmpm.setup.obstacle_reach import doubts
from snowmpm.setup.refusals import require
from snowmpm.stages import stage
from snowmpm.stepping.abilities import obstacle_totals
from snowmpm.stepping.contract import Method, TakesLoads
from snowmpm.stepping.settling import settle
from snowmpm.stepping.step_check import check_step, rounded_down

COLLAPSE = 1e-5
"""Share of the first time step below which a run is stopped as unstable."""


class Simulation(Glance):
    """A scene in motion.

        sim = Simulation(scene)
        while sim.time < 1.0:
            sim.step()
        sim.particles["velocity"]

    time [s]; dt [s] and dt_cause of the last step: "elastic", "breaking" (elastic, shorter because bonds break),
    "advective", "deformation", "fixed", "output" (shortened to end at a requested time) or "window" (repeated with
    another program); particles[name]: NumPy
    copies (`snowmpm.particles.fields.ParticleFields`).
    files: digest of each file that the scene names, by key, as it was read.
    settling_steps: before the clock started, in which the initial state settled.
    Several simulations can be used alternately, also in several threads; one computes at a time.
    Raises InputError for a scene that cannot be built, SimulationError when a step fails, EndedError after `ti.init` or
    `ti.reset` and in a forked process.
    """

    scene: Scene
    model: Model
    relay: Relay
    solver: Method
    events: list[Any]
    crack: Any
    files: dict[str, str]
    dt: float
    dt_cause: str
    settling_steps: int

    def __init__(self, scene: Scene, resumed: PathLike | None = None,
                 approve: "Callable[[Simulation], object] | None" = None) -> None:
        """resumed: run folder whose checkpoint provides the state. Then an initial stress "settle" is not relaxed
        again, and the state from another run (`initial.from`) is read from that folder.

        approve: called with the simulation once it is built, before it settles; may raise InputError to refuse it.
        """
        with compiling(), noting({}) as read:
            self._make(scene, resumed, approve)
        self.files = digests(scene, read)

    def _make(self, scene: Scene, resumed: PathLike | None, approve: "Callable[[Simulation], object] | None") -> None:
        self.scene = scene
        self.model = build(scene, resumed)
        self._start = lifetime.current()
        self.relay = Relay(scene, self.model)
        """Which method is at work, and what it took over (`snowmpm.running.relay`)."""
        self.solver = self.model.solver()
        self.events = [*make_events(scene), *(HandOver(i, switch) for i, switch in enumerate(scene.switch))]
        self.dt, self.dt_cause = 0.0, "elastic"
        self._first_dt: float | None = None
        self.settling_steps = 0
        check_step(scene, self.solver)
        self._stepping = components.stepping(self)
        self._fastest = fall_speed(self.model)
        if approve:
            approve(self)
        if resumed is None:
            for doubt in (*doubts(self.model), *mass_doubts(self.model), *overloaded(scene)):
                warnings.warn(str(doubt), stacklevel=2)
        if scene.initial.stress == "settle" and resumed is None and not self._begins_at_rest():
            self.settle()
        if resumed is None:
            self.solver.time = rests_until(scene)
        self.crack = CrackRecord(self, self.events[-1]) if scene.saw_test else None
        """Record of the saw test (`snowmpm.saw_test.crack`); None if there is none."""
        if self.crack and resumed is None:
            for line in self.crack.before_the_saw():
                warnings.warn(line, stacklevel=2)
        direction = None if scene.saw_test else self.model.direction
        self._audit = Audit(self.solver, self.particles, direction, self.model.population.positions,
                            plan=self.scene.solver.in_plan)
        self._audit.past = self.relay.past

    def _glance(self) -> tuple[str, dict[str, Any]]:
        scene, solver = self.scene, self.relay.scene.solver
        facts = {"time": f"{self.time:.6g} of {scene.end_time:g} s, {counted(self.solver.steps)} steps",
                 "particles": counted(self.n_particles),
                 "last step": f"{self.dt:.4g} s ({self.dt_cause})" if self.solver.steps else "none yet",
                 "solver": f"{solver.method}, dx = {solver.dx:g} m, {solver.precision}"}
        return f"Simulation of {scene.name} ({scene.dimension}-D)", facts

    @property
    def time(self) -> float:
        return self.solver.time

    @property
    def n_particles(self) -> int:
        """Number of particles in the domain now."""
        return self.solver.particles.count

    @property
    def max_speed(self) -> float:
        """Largest particle speed after the last step [m/s]."""
        return self.solver.extremes.speed

    @property
    def motion(self) -> Motion:
        """How much of the snow moved at the last audit, a frame or the start (`snowmpm.quantities.motion.Motion`)."""
        return self._audit.motion

    @property
    @in_turn
    def particles(self) -> ParticleFields:
        return ParticleFields(self.solver.particles, self.relay.model.body_starts)

    def law_of_body(self, body: int) -> Law:
        """Law of the body with this index, scaled to this grid."""
        return self.relay.model.laws[list(self.scene.materials).index(self.scene.bodies[body].material)]

    def numbers_of_body(self, body: int) -> tuple[int, int]:
        """First particle number of a body, and one past its last."""
        model = self.relay.model
        ends = [*model.body_starts, len(model.population.volumes)]
        return int(ends[body]), int(ends[body + 1])

    @in_turn
    def step(self, until: float | None = None) -> None:
        """Advance by one step: the largest stable one, shortened so that whole steps land on `until` [s].

        A component may compute the steps in its own time windows (`components.contract.Component.steps`)."""
        if self._stepping:
            self._stepping.step(until)
        else:
            self.advance(until)

    def advance(self, until: float | None = None) -> None:
        """`step` without regard to such windows."""
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
            known = diagnose(self.relay.scene.solver, self.solver, dt, components.symptoms(self.scene))
            # Two lines: a hint from the atlas of failures is more useful than general advice
            raise SimulationError(f"{str(error).splitlines()[0]}\n{known}" if known else str(error)) from error
        if self.max_speed > self._fastest:
            raise SimulationError(f"snow moves at {self.max_speed:.4g} m/s at t = {self.time:.6g} s, and a fall over"
                                  f" all of the ground gives {self._fastest:.4g} m/s:\ncheck the terrain for steps that"
                                  " no ground has, and the friction; lower solver.cfl")
        if until is not None and abs(until - self.time) < 1e-9 * max(1.0, until):
            self.solver.time = until
        self.dt, self.dt_cause = dt, cause
        if self.crack:
            self.crack.watch()

    @in_turn
    def add_acceleration(self, function: Callable[[Floats, Floats, float], ArrayLike]) -> None:
        """Add an acceleration that acts from now on: function(x (n, dim) [m], v (n, dim) [m/s], time [s]) returns
        accelerations (n, dim) or (dim,) [m/s2]. A checkpoint does not store it: add it again after restoring."""
        method = self.relay.scene.solver.method
        accelerating, self._fastest = components.accelerating(), math.inf
        require(self.relay.scene, accelerating.name, "solver.method", method, what="for add_acceleration")
        resolved(accelerating.accelerates)(self.solver, function)

    @in_turn
    def audit(self, particles: ParticleFields | None = None) -> dict[str, float]:
        """One row of the history: conserved quantities, energies, front, counters (`snowmpm.running.audit`)."""
        row = {**self._audit.values(particles or self.particles), "dt": self.dt}
        if self.scene.switch:
            row.update(method=self.relay.index, handover_energy=self.relay.past.handover_energy)
        if self.scene.zone:
            row.update(handover_energy=self.solver.totals.handover_energy)
        return row

    @property
    def obstacle_totals(self) -> Floats:
        """What the snow gave each obstacle since time zero (`stepping.contract.PushesObstacles.obstacle_totals`)."""
        return self.relay.past.with_obstacles(obstacle_totals(self.solver))

    def energies(self) -> dict[str, float]:
        """Energies of the snow now by kind [J] (`snowmpm.running.audit`)."""
        return self._audit.energies(self.particles)

    def goes_on_with(self, solver: Method) -> None:
        """Let another solver take over, as the `relay` has made it."""
        self.solver, self._first_dt = solver, None
        self._audit.continue_with(solver, self.relay)

    @in_turn
    def follow_loads(self) -> None:
        """Pass the loads of all events to the solver, in the order of the scene."""
        if isinstance(self.solver, TakesLoads):
            self.solver.set_loads([event.load for event in self.events if event.load is not None])

    @in_turn
    def state(self) -> dict[str, Any]:
        """All that a bitwise continuation needs, by name (`snowmpm.io.checkpoint`), as copies."""
        rest = {"events": [event.state() for event in self.events], "audit": self._audit.state(),
                **({"relay": self.relay.state()} if self.scene.switch else {}),
                "body_starts": self.model.body_starts, "dt": self.dt, "dt_cause": self.dt_cause,
                "crack": self.crack.state() if self.crack else {}}
        return {"solver": self.solver.state(), **copy.deepcopy(rest)}

    @in_turn
    def restore(self, state: Mapping[str, Any]) -> None:
        """Restore the `state()` of a simulation of the same scene. Raises InputError when it does not fit."""
        if not np.array_equal(state["body_starts"], self.model.body_starts):
            raise InputError(f"{self.scene.source}: bodies: not as many particles as when the run began")
        if self.scene.switch and self.relay.restore(state["relay"]):
            self.goes_on_with(self.relay.solver())
        self._audit.past = self.relay.past
        self.solver.restore(state["solver"])
        for event, own in zip(self.events, state["events"], strict=True):
            event.restore(own)
        self.follow_loads()
        self._audit.restore(state["audit"])
        if self.crack:
            self.crack.restore(state["crack"])
        self.dt, self.dt_cause = state["dt"], state["dt_cause"]

    def _next_step(self) -> tuple[float, str]:
        fixed = self.relay.scene.solver.dt
        if fixed:
            limit, cause = self.solver.critical_dt()
            if fixed > limit:
                raise SimulationError(f"solver.dt = {fixed:g} s is too long at t = {self.time:.6g} s: the {cause} limit"
                                      f" is {rounded_down(limit)} s; leave solver.dt out for an adaptive step")
            return fixed, "fixed"
        dt, cause = self.solver.stable_dt()
        first = self._first_dt = self._first_dt or dt
        if not dt > COLLAPSE * first:
            raise SimulationError(f"the time step fell to {dt:.3g} s at t = {self.time:.6g} s, by the {cause} limit,"
                                  f" from {first:.3g} s at the start:\nthe snow moves faster, or is stiffer,"
                                  " than anything real; lower solver.cfl or check the material")
        return dt, cause

    def _begins_at_rest(self) -> bool:
        """Let the solver begin from a balance that the scene asks for, and that a static solver finds."""
        if self.scene.initial.relaxation != "static":
            return False
        with stage("finding the balance"):
            found = self.model.at_rest()
        if found is not None:
            self.solver = self.model.solver(found.population)
        return found is not None

    @in_turn
    def settle(self) -> None:
        """Relax to rest under gravity (`snowmpm.stepping.settling`). Raises SimulationError when it does not settle."""
        wanted = self.scene.initial.tolerance
        rest = settle(self.solver, wanted, max(self.model.depth, self.scene.solver.dx))
        self.settling_steps = rest.steps
        if not rest.settled:
            raise SimulationError(f"{self.scene.source}: initial.stress = \"settle\": not at rest after {rest.steps}"
                                  f" steps: speed {rest.speed:.2g} sqrt(g D), imbalance {rest.imbalance:.2g} of the"
                                  f" weight, initial.tolerance = {wanted:g}; {self._fastest_body()};\nthe scene is not"
                                  " stable before its trigger, or wants a larger tolerance")

    def _fastest_body(self) -> str:
        """In words: which body moves most."""
        fields = self.particles
        speed = np.linalg.norm(fields["velocity"], axis=1)
        first = int(np.argmax(speed))
        body = int(fields["body"][first])
        return f'"{self.scene.bodies[body].name}" moves most, {speed[first]:.2g} m/s'
