"""Columns in plan, and within a region particles in space, at the same time.

Each step of the columns begins with the exchange of snow: columns in the region become particles (`handover.filling`,
laid on what lies there), particles that have left it become columns (`handover.gathering`). Mass and momentum in plan
stay to round-off; what energy is lost is counted.

Where both methods hold snow, or lie beside each other, their depths add up to that of the snow, and each feels the
depth of the other as a depth-averaged flow does. With the depths H of the columns and H' of the particles,

    columns:    dw/dt = ... - M^-1 grad phi(H + H'),    particles:    dv/dt = ... - M^-1 grad phi(H)

The particles take part in the columns' step as guests, gathered into columns that move on at their velocity; what the
columns do to the particles is given them at once, before their own steps, as many as the columns' step holds. What
both give each other is equal and opposite but for the change within a step, and for what the ground takes of it.
"""

import copy
import math
from dataclasses import replace
from typing import Any

import numpy as np

from snowmpm.annotations import derived
from snowmpm.errors import SimulationError
from snowmpm.handover.chosen import Chosen
from snowmpm.handover.filling import filled
from snowmpm.handover.gathering import gathered
from snowmpm.handover.joined import JoinedParticles
from snowmpm.handover.numbering import Numbering
from snowmpm.particles.fields import ParticleFields
from snowmpm.particles.population import Population
from snowmpm.solids import inside_any
from snowmpm.stepping.contract import Affine, Forecasts, Method, PushesObstacles, Removes, Totals

SHARE = 0.5
"""Cells of the columns that snow may cross in a step while there are particles."""

MOST_STEPS = 100_000
"""Steps of the particles in a step of the columns, beyond which they no longer go on."""


class Nested(Method, Removes, PushesObstacles, Affine, Forecasts):
    """outer: method of the columns; inner: method of the particles, which has none at time zero."""

    particles: JoinedParticles
    contact_work: Any

    def __init__(self, outer, inner, model, within, border):
        """model, within: `setup.model.Model` of the scene, and of its zone; border: `Border`."""
        self.outer, self.inner, self.border = outer, inner, border
        self._model, self._within = model, within
        self._spacing, self._n_bodies = model.scene.solver.spacing(3), len(model.scene.bodies)
        self.frame = outer.frame
        self.particles = JoinedParticles(outer.particles, inner.particles,
                                         Numbering(model.body_of, model.population.positions))
        self._tell_numbers()
        self.steps, self.handover_energy = 0, 0.0
        self._lifted = 0.0  # vertical momentum that snow gained in changing its method [N s]
        place = {id(obstacle): i for i, obstacle in enumerate(model.obstacles)}
        self._obstacles = [place[id(obstacle)] for obstacle in within.obstacles]

    def _tell_numbers(self):
        for part in (self.outer.particles, self.inner.particles):
            part.bodies, part.origins = self.particles.bodies, self.particles.origins

    # ---- the step ---------------------------------------------------------------------------------------------

    def step(self, dt):
        """Advance by dt [s]."""
        self._leave()
        self._enter()
        self._press(dt)
        self.outer.step(dt)
        self.particles.moved = self.outer.particles.count
        self._step_inner(dt)
        self.steps += 1

    def _step_inner(self, dt):
        """Let the particles catch up."""
        left, taken = dt, 0
        while self.inner.particles.count and left > 1e-12 * dt:
            longest = self.inner.stable_dt()[0]
            n = max(1, math.ceil(left / longest * (1.0 - 1e-9)))
            taken += 1
            if n + taken > MOST_STEPS:
                raise SimulationError(f"the time step of the zone fell to {longest:.3g} s at t = {self.time:.6g} s:\n"
                                      "the snow moves faster, or is stiffer, than anything real; lower zone.solver.cfl")
            self.inner.step(left / n)
            self.particles.moved += self.inner.particles.count
            left -= left / n
        self.inner.time = self.outer.time

    # ---- from one method to the other -------------------------------------------------------------------------

    def _leave(self):
        """Particles beyond the region become columns."""
        if not self.inner.particles.count:
            return
        fields = ParticleFields(self.inner.particles)
        gone = self.border.left(fields.snapshot.plan())
        if gone.any():
            handed = gathered(Chosen(fields, gone), self.particles.origins, self._spacing, self._n_bodies)
            self._pass(self.inner, self.outer, gone, handed)

    def _enter(self):
        """Columns in the region become particles."""
        columns = self.outer.particles
        gone = self.border.entered(columns.snapshot().plan())
        gone[columns.count - columns.waiting :] = False
        if not gone.any():
            return
        model, part = self._model, self._within
        handed = filled(Chosen(ParticleFields(columns), gone), self.particles.origins, model.surface,
                        model.scene.solver.dx, part.scene, part.laws, self._depth_there())
        if inside_any(part.obstacles, handed.population.positions, self.time).any():
            raise SimulationError(f"at t = {self.time:.6g} s, snow that enters the zone lies inside an obstacle:\n"
                                  "choose a larger zone.region, from six cells of solver.dx before the obstacle on")
        self._pass(self.outer, self.inner, gone, handed)

    def _depth_there(self):
        """Places in plan (k, 2) [m] -> vertical depth (k,) [m] of the particles there: a mean over the squares of their
        spacing around each."""
        store = self.inner.particles
        side = self._within.scene.solver.spacing(3)
        plan = store.snapshot().plan()
        if not len(plan):
            return None
        volume = store.column("volume")[:, 0] * store.column("volume_ratio")[:, 0]
        at = np.floor(plan / side).astype(np.int64)
        low = at.min(axis=0) - 1
        depth: Any = np.zeros(np.ptp(at, axis=0) + 3)
        np.add.at(depth, tuple((at - low).T), volume / (9.0 * side**2))
        depth = sum(np.roll(depth, (i, j), axis=(0, 1)) for i in (-1, 0, 1) for j in (-1, 0, 1))

        def depth_at(places):
            cell = np.floor(places / side).astype(np.int64) - low
            there = ((cell >= 0) & (cell < depth.shape)).all(axis=1)
            found = np.zeros(len(places))
            found[there] = depth[tuple(cell[there].T)]
            return found

        return depth_at

    def _pass(self, giver, taker, gone, handed):
        """Give the rows `gone` (n,) of a method, as `Handed`, to the other."""
        before = copy.deepcopy(giver.particles.removed)
        giver.remove(gone)
        passed = {name: value - before[name] for name, value in giver.particles.removed.items()}
        self.particles.pass_on(passed)
        numbers = self.particles.numbering.give(handed)
        # The energy of columns is one of pairs, that of particles their own
        held = self._worth_of_columns() if taker is self.outer else 0.0
        taker.receive(handed.population, numbers)
        self._tell_numbers()
        worth = self._worth_of_columns() - held if taker is self.outer else self._worth(handed.population)
        self.handover_energy += float(passed["energy"]) - worth[0]
        self._lifted += worth[1] - float(passed["momentum"][-1])

    def _worth_of_columns(self):
        """Energy [J] and vertical momentum [N s] of all columns."""
        fields = ParticleFields(self.outer.particles)
        mass, v = fields["mass"], fields["velocity"]
        return np.array([0.5 * mass @ (v**2).sum(axis=1) - mass @ (fields["position"] @ self.gravity), mass @ v[:, -1]])

    def _worth(self, population):
        """Energy [J] and vertical momentum [N s] of a `Population` of particles."""
        materials = self.inner.particles.materials
        mass, v = population.volumes * materials.density[population.material], population.velocities
        state = materials.state_of(population, np.arange(len(mass)))
        elastic = materials.elastic_energy(population.material, population.stress, state, population.volumes)
        return np.array([0.5 * mass @ (v**2).sum(axis=1) - mass @ (population.positions @ self.gravity) + elastic,
                         mass @ v[:, -1]])

    def _press(self, dt):
        """Let the snow of both methods feel each other for dt [s]."""
        store, guests = self.inner.particles, Population(np.zeros((0, 3)), np.zeros(0), 0)
        if store.count and self.outer.particles.count:
            fields = ParticleFields(store)
            plan = fields.snapshot.plan()
            near = self.border.beside(plan, self.outer.particles.snapshot().plan())
            if near.any():
                guests = gathered(Chosen(fields, near), self.particles.origins, self._spacing,
                                  self._n_bodies).population
                gain = np.zeros((len(plan), 3))
                gain[near] = dt * self.outer.pull(plan[near])
                self.inner.accelerate(gain)
        self.outer.invite(guests)

    # ---- the contract: both together --------------------------------------------------------------------------

    @property
    def time(self):
        """[s]"""
        return self.outer.time

    @time.setter
    def time(self, value):
        self.outer.time = self.inner.time = value

    @derived
    def gravity(self):
        """(3,) [m/s2]"""
        return self.outer.gravity

    @derived
    def extremes(self):
        """Those of the particles, with the speed of the fastest of both."""
        speed = self.inner.extremes.speed if self.inner.particles.count else 0.0
        return replace(self.inner.extremes, speed=max(speed, self.outer.extremes.speed))

    @derived
    def unconverged(self):
        """Return maps that failed since time zero."""
        return self.inner.unconverged

    @property
    def limits(self):
        """Of the columns' step."""
        return self.outer.limits

    def _slower(self, dt, cause):
        """A step of the columns, no longer than until the fastest particle has crossed `SHARE` of their cells."""
        if not self.inner.particles.count:
            return dt, cause
        way, g, v = SHARE * self.frame.dx, float(np.linalg.norm(self.gravity)), self.extremes.speed
        crossing = 2.0 * way / (v + math.sqrt(v**2 + 2.0 * g * way))
        return (crossing, "advective") if crossing < dt else (dt, cause)

    def stable_dt(self):
        """-> (step for now [s], what limits it)."""
        return self._slower(*self.outer.stable_dt())

    def critical_dt(self):
        """-> (longest stable step [s], what limits it)."""
        return self._slower(*self.outer.critical_dt())

    def expected_dt(self, breaking=False):
        """-> (step that a run takes about [s], what limits it): the one for now."""
        return self.stable_dt()

    def course(self, end_time, interval):
        """That of the columns, were there no zone."""
        return self.outer.course(end_time, interval)

    def remove(self, gone):
        """Take out columns and particles, in the order of the rows."""
        n = self.outer.particles.count
        for method, part in ((self.outer, gone[:n]), (self.inner, gone[n:])):
            if part.any():
                method.remove(part)

    def restart_clock(self):
        """Time zero is now: totals start again."""
        self.outer.restart_clock()
        self.inner.restart_clock()
        self.steps, self.handover_energy, self._lifted = 0, 0.0, 0.0

    @property
    def totals(self):
        """`Totals` of both."""
        first, second = self.outer.totals, self.inner.totals
        both = {name: vars(first)[name] + vars(second)[name] for name in (
            "impulse", "weight_impulse", "momentum_gain", "plastic_work", "contact_work", "yielding")}
        both["impulse"][-1] += self._lifted
        return Totals(**both, handover_energy=self.handover_energy)

    @property
    def obstacle_totals(self):
        """Of the obstacles in the zone by the particles, of the others by the columns."""
        outside = [i for i in range(len(self._model.obstacles)) if i not in self._obstacles]
        totals = np.zeros((len(self._model.obstacles), 7))
        for rows, method in ((outside, self.outer), (self._obstacles, self.inner)):
            if rows:
                totals[rows] = method.obstacle_totals
        return totals

    def second_moment(self):
        """D [m2] of the particles; columns have no affine motion."""
        return self.inner.second_moment()

    def null_space_noise(self, energy):
        """Share of the kinetic energy [J] of all snow that the grid of the particles cannot see."""
        if not self.inner.particles.count:
            return 0.0
        fields = ParticleFields(self.inner.particles)
        mass = fields["mass"]
        own = 0.5 * float(mass @ (fields["velocity"] ** 2).sum(axis=1)) + 0.5 * self.second_moment() * float(
            mass @ (fields.velocity_gradient() ** 2).sum(axis=1))
        return self.inner.null_space_noise(own) * own / energy if own > 0.0 else 0.0

    @property
    def memory(self):
        """Bytes of everything but columns and particles."""
        return self.outer.memory + self.inner.memory

    @property
    def workload(self):
        """`Workload` of a step of the columns."""
        return self.outer.workload

    # ---- checkpoint -------------------------------------------------------------------------------------------

    def state(self):
        """All that a bitwise continuation needs, by name."""
        return {"outer": self.outer.state(), "inner": self.inner.state(), "steps": self.steps,
                "passed": copy.deepcopy(self.particles.passed), "handover_energy": self.handover_energy,
                "lifted": self._lifted, "numbering": self.particles.numbering.state()}

    def restore(self, state):
        """Take over the `state()` of a method of the same scene. Raises InputError when it does not fit."""
        self.outer.restore(state["outer"])
        self.inner.particles.make_room(len(state["inner"]["reals"]))
        self.inner.restore(state["inner"])
        self.steps, self.handover_energy, self._lifted = state["steps"], state["handover_energy"], state["lifted"]
        self.particles.passed = dict(state["passed"])
        self.particles.numbering = Numbering.of(state["numbering"])
        self._tell_numbers()
