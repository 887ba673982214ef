"""The methods that compute a scene one after the other, and what each hands over to the next.

At a hand-over mass, momentum in plan and centre of mass in plan stay to round-off (`snowmpm.handover`). Energy does
not: what is lost, or gained where the snow is put elsewhere vertically or gets a stress, is booked as
`handover_energy`. The change of the vertical momentum counts as an impulse of the ground.
"""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from snowmpm.annotations import Floats
from snowmpm.errors import SimulationError
from snowmpm.handover.conversion import converted
from snowmpm.handover.handed import Handed
from snowmpm.handover.moment import LOOK, Moment, at_rest
from snowmpm.running.events import Event
from snowmpm.scenes.switch import parts
from snowmpm.solids import inside_any
from snowmpm.stepping.abilities import obstacle_totals
from snowmpm.stepping.contract import Method, Totals
from snowmpm.stepping.step_check import check_step

if TYPE_CHECKING:
    from snowmpm.running.simulation import Simulation
    from snowmpm.scenes.schema import Scene
    from snowmpm.setup.model import Model


@dataclass
class Past:
    """What earlier methods have added up: impulse and weight_impulse (dim,) [N s], plastic_work, contact_work and
    handover_energy [J], obstacles (n, dim + 1 or 3 + 1) as `PushesObstacles.obstacle_totals`."""

    impulse: Floats
    weight_impulse: Floats
    obstacles: Floats
    plastic_work: float = 0.0
    contact_work: float = 0.0
    handover_energy: float = 0.0

    @classmethod
    def none(cls, dim: int, obstacles: int) -> "Past":
        """Of the first method; obstacles: how many there are."""
        return cls(np.zeros(dim), np.zeros(dim), np.zeros((obstacles, dim + (1 if dim == 2 else 3) + 1)))

    def plus(self, totals: Totals) -> Totals:
        """`Totals` of all methods so far, from those of the one at work."""
        return replace(totals, **{name: vars(self)[name] + vars(totals)[name]
                                  for name in ("impulse", "weight_impulse", "plastic_work", "contact_work")})

    def with_obstacles(self, totals: Floats) -> Floats:
        """Totals of obstacles so far; totals: of the method at work, without rows where it has no obstacles."""
        return self.obstacles + totals if len(totals) == len(self.obstacles) else self.obstacles.copy()


class Relay:
    """Which method is at work.

    scene: of its part (`scenes.switch.parts`); model: from which its solver was built; start (n, dim) [m]: where the
    snow of its particles was at time zero, by number; past: `Past`; records: of each method so far, its name, the time
    [s] at which it began, its dx and particle_spacing [m], particles, and the energy lost in coming to it by kind [J].
    """

    model: "Model"
    past: Past
    start: Floats
    records: list[dict[str, Any]]
    index: int

    def __init__(self, scene: "Scene", model: "Model") -> None:
        self._parts, self._first, self.index = parts(scene), model, 0
        self._moments = [Moment(switch, model.surface, scene.base_dir, f"switch.{i}")
                         for i, switch in enumerate(scene.switch)]
        self.model, self.start, self._handed = model, model.population.positions, None
        self.past = Past.none(scene.dimension, len(model.obstacles))
        self.records = [self._record(0.0)]

    @property
    def scene(self) -> "Scene":
        """Of the method at work."""
        return self._parts[self.index]

    @property
    def next(self) -> Moment | None:
        """`Moment` of the next hand-over; None after the last."""
        return self._moments[self.index] if self.index < len(self._moments) else None

    def solver(self) -> Method:
        """The solver of the method at work, as it takes over."""
        solver = self.model.solver()
        check_step(self.scene, solver)
        return solver

    def take_over(self, simulation: "Simulation") -> None:
        """Replace the solver of a simulation by that of the next method, with the same snow and clock."""
        old: Any = simulation.solver
        switch = self._moments[self.index].switch
        if switch.at_rest == "stays":
            old.remove(at_rest(simulation.particles))
        fields = simulation.particles
        handed = converted(fields, self.start, self.scene, self._parts[self.index + 1], self._first)
        in_space = not self._parts[self.index + 1].solver.in_plan
        if in_space and inside_any(self._first.obstacles, handed.population.positions, old.time).any():
            raise SimulationError(f"at t = {old.time:.6g} s, the hand-over to {switch.to} comes too late: snow lies"
                                  " inside an obstacle;\nhand over earlier (switch.when), or in a larger switch.region")
        before, momentum = simulation.energies(), fields["mass"] @ fields["velocity"]
        self._add(old)
        self._begin(self.index + 1, handed)
        solver = self.solver()
        solver.particles.removed.update({**old.particles.removed, "momentum": old.particles.removed["momentum"].copy()})
        solver.restart_clock()
        solver.time, solver.steps, solver.unconverged = old.time, old.steps, old.unconverged
        simulation.goes_on_with(solver)
        fields = simulation.particles
        self.past.impulse[-1] += (fields["mass"] @ fields["velocity"] - momentum)[-1]
        lost = {name: value - now for (name, value), now in zip(before.items(), simulation.energies().values(),
                                                                strict=True)}
        self.past.handover_energy += sum(lost.values())
        self.records.append({**self._record(old.time), **lost})

    def _add(self, solver):
        """Add up what a solver has done."""
        totals = self.past.plus(solver.totals)
        self.past = Past(totals.impulse.copy(), totals.weight_impulse.copy(),
                         self.past.with_obstacles(obstacle_totals(solver)), totals.plastic_work, totals.contact_work,
                         self.past.handover_energy)

    def _begin(self, index, handed):
        self.index, self._handed, self.start = index, handed, handed.start
        self.model = replace(self._first, scene=self.scene, population=handed.population,
                             body_starts=handed.body_starts)

    def _record(self, time):
        solver = self.scene.solver
        return {"method": solver.method, "time": float(time), "dx": solver.dx,
                "particle_spacing": solver.spacing(self.scene.dimension),
                "particles": len(self.model.population.volumes)}

    def state(self) -> dict[str, Any]:
        """All that a continuation needs, by name."""
        return {"index": self.index, "past": asdict(self.past), "records": self.records,
                "handed": self._handed.state() if self._handed else {}}

    def restore(self, state: Mapping[str, Any]) -> bool:
        """Restore the result of `state()`; -> whether another method is at work than before."""
        changed = state["index"] > 0
        if changed:
            self._begin(state["index"], Handed.of(state["handed"]))
        self.past, self.records = Past(**state["past"]), list(state["records"])
        return changed


class HandOver(Event):
    """A hand-over: once its moment has come, all other events are over and the one before is done."""

    def __init__(self, index, switch):
        super().__init__(switch, None)
        self._index, self._way = index, 0.0  # way [m] of the fastest snow since the last look

    def state(self):
        return {**super().state(), "way": self._way}

    def restore(self, state):
        super().restore(state)
        self._way = state["way"]

    def to_come(self, time):
        """Only at a given time: snow at rest does not bring about the others."""
        return not self.done and self._spec.time is not None

    def apply(self, simulation):
        relay, others = simulation.relay, [event for event in simulation.events if not isinstance(event, HandOver)]
        if relay.index != self._index or any(event.to_come(simulation.time) for event in others):
            return
        self._way += simulation.max_speed * simulation.dt
        if self._looks(simulation) and simulation.n_particles and relay.next.has_come(simulation):
            relay.take_over(simulation)
            self.done = True

    def _looks(self, simulation):
        if self._spec.time is None and simulation.solver.steps % LOOK and self._way < simulation.relay.scene.solver.dx:
            return False
        self._way = 0.0
        return True

