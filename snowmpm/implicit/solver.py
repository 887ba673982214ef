"""Implicit MPM: the particles, splines, laws and surfaces of explicit MPM, with steps that are solved for."""

import math
from dataclasses import replace
from typing import Any

import numpy as np

from snowmpm.errors import InputError, SimulationError
from snowmpm.implicit.material_points import MaterialPoints
from snowmpm.implicit.step_solver import Grid, Rules, StepSolver
from snowmpm.implicit.surfaces import surfaces_of
from snowmpm.mpm.transfer.stencil import STENCILS
from snowmpm.particles.blocks import EDGE
from snowmpm.particles.sorted_particles import SortedParticles, Sorting
from snowmpm.schemes import TRANSFERS
from snowmpm.stepping.component import Adapters
from snowmpm.stepping.contract import StepLimits, Workload
from snowmpm.stepping.method import Severing, Solver
from snowmpm.stepping.setting import Setting
from snowmpm.stepping.time_step import DEFORMATION_LIMIT, Extremes

USUAL_ADVECTIVE = 0.5
"""Cells that a particle crosses in a step of a scene that gives no cfl: its weights are those of the start."""

TO_THE_NEXT_FRAME = 1e6
"""Step [s] of a scene at rest that gives none: it ends with the frame."""


class ImplicitSolver(Solver, Severing):
    """Particles, and steps of them that `StepSolver` solves."""

    def __init__(self, population, laws, choices, options, **setting):
        """choices: kernel, gradient, transfer, flip_ratio, as of a scene's solver table; options: its table implicit
        (`scenes.numerics.Implicit`); setting: fields of `Setting`, obstacles at rest."""
        given = Setting(**setting)
        self.dim, self.dx, self.precision, self.options = given.dim, given.dx, given.precision, options
        self.adapters = Adapters(given.adapters)
        self.at_rest = options.time == "quasi_static"
        self.frame = given.frame()
        period = self.frame.period(given.walls)
        moving = TRANSFERS[choices.transfer]
        grid = Grid(self.dx, self.frame.origin, choices.kernel, choices.gradient, surfaces_of(self.frame, given),
                    period=EDGE[self.dim] * period)
        rules = Rules(options.time, options.tolerance, options.iterations, options.linear, options.damping,
                      choices.flip_ratio if moving.flip else 0.0)
        self.scheme_name = f"implicit MPM ({options.time})"
        self.cfl = given.cfl or USUAL_ADVECTIVE
        self.critical_cfl = math.inf
        self.surfaces = []
        self.particles = SortedParticles(
            population, laws, self.frame, given.gravity, Sorting(STENCILS[choices.kernel].drift_limit), period,
            self.adapters.of_particles)
        self._begin(population, given.gravity)
        self.step_solver = StepSolver(grid, rules, self.particles.materials)
        self._acceleration = np.zeros((len(population.volumes), self.dim))
        self._held_impulse = np.zeros(self.dim)
        self.contact_work = 0.0
        """energy that friction took [J]"""
        self.lines, self.spared = 0, 0
        """lines of contact that touched, and those of them that a rule settled (`touch`), added up over all steps"""
        self._may_part = any(not surface.fixed for surface in grid.surfaces)
        self._given, self._pressing = np.zeros((2, len(given.obstacles), self.dim + (1 if self.dim == 2 else 3)))
        self._fresh, self._scene_loads = True, []
        self.passed: Any = None
        """`step_solver.StepResult` of the last step"""
        if self.at_rest:
            self._stop()
        self.adapters.begin(self)

    @classmethod
    def of(cls, population, laws, chosen, **setting):
        """Of a scene's solver table (`snowmpm.methods.MethodEntry`)."""
        return cls(population, laws, chosen, chosen.implicit, **setting)

    def _stop(self):
        """At rest, a velocity is an impulse that a step has still to carry."""
        table = self.particles.table()
        table[:, self.particles.layout.columns("velocity")] = 0.0
        self.particles.overwrite(table)

    # ---- the step ---------------------------------------------------------------------------------------------

    def step(self, dt):
        """Advance by dt [s]. Raises SimulationError when the step cannot be solved."""
        store = self.particles
        before = store.column("velocity") if self.adapters.before_step and store.count else None
        self._act(dt)
        if store.count:
            matter = MaterialPoints.of_store(store)
            gain = None if before is None else matter.velocity - before
            around = next((found for take in self.adapters.around if (found := take()) is not None), None)
            if around:
                matter.around, book = around
            matter.strain = next(iter(self.adapters.strain), None)
            matter.terms = [make(matter, self.time + dt) for make in self.adapters.terms]
            ratio = matter.ratio
            if not np.isfinite(matter.velocity).all():
                self._fail(int(np.flatnonzero(~np.isfinite(matter.velocity).all(axis=1))[0]))
            try:
                self.passed = self._rest(matter, dt) if self.at_rest else self._move(matter, dt, gain)
            except SimulationError as error:
                raise SimulationError(f"{error}, at t = {self.time:.6g} s, step {self.steps}:\n"
                                      "lower solver.implicit.dt, or look for snow that nothing holds") from None
            if around:
                book(-float((matter.volume * matter.around) @ (matter.ratio - ratio)))
            self._take(matter, dt)
        self._advance_clock(dt, dt)

    def _body(self, matter):
        """Acceleration of weight and loads (n, dim) [m/s2], and that of loads alone."""
        loads = np.zeros_like(matter.velocity)
        x = self.frame.origin + self.dx * matter.cells
        for centre, radius, acceleration in self._scene_loads:
            loads[np.linalg.norm(x - np.asarray(centre), axis=1) < radius] += np.asarray(acceleration)
        return self.gravity + loads, loads

    def _rest(self, matter, dt):
        body, loads = self._body(matter)
        self._loaded += dt * (matter.mass @ loads)
        # Impulses of events and forces since the last step are velocities by now: as forces over the step
        return self.step_solver.to_balance(matter, body + matter.velocity / dt, dt)

    def _move(self, matter, dt, gain=None):
        """gain (n, dim) [m/s]: what forces of the scene gave before the step, which act over it."""
        body, loads = self._body(matter)
        if gain is not None:
            matter.velocity = matter.velocity - gain
            body = body + gain / dt
        acceleration = self._acceleration[matter.number]
        passed = self.step_solver.in_time(matter, acceleration, body, dt, self._fresh, self._pressing)
        self._acceleration[matter.number], self._fresh = acceleration, False
        self._loaded += dt * (matter.mass @ loads)
        return passed

    def _take(self, matter, dt):
        """Put particles back, and keep the books."""
        store, passed = self.particles, self.passed
        self._held_impulse += passed.impulse
        self._loaded += passed.loaded
        self._given, self._pressing = self._given + passed.given, self._pressing * 0.0 + passed.pressing
        self.contact_work += passed.rubbed
        self.lines, self.spared = self.lines + passed.lines, self.spared + passed.spared
        self.plastic_work += passed.work
        self.unconverged += passed.unconverged
        self.n_plastic = passed.yielding
        store.place(matter.cells, matter.changed())
        self.extremes = Extremes(
            speed=float(np.linalg.norm(matter.velocity, axis=1).max()),
            gradient=float(np.linalg.norm(matter.affine, axis=(1, 2)).max()),
            elastic_deviation=float(np.linalg.norm(matter.h, axis=1).max()))

    BAD = "is no longer finite"

    # ---- the length of a step ---------------------------------------------------------------------------------

    def stable_dt(self):
        """-> (step for now [s], what limits it): solver.implicit.dt, else waves in time, the next frame at rest."""
        if self.options.dt:
            return self.options.dt, "fixed"
        if self.at_rest:
            return TO_THE_NEXT_FRAME, "elastic"
        limits = {"elastic": self.options.courant * self.dx / self.materials.wave_speed}
        if self.extremes.speed > 0.0:
            limits["advective"] = self.cfl * self.dx / self.extremes.speed
        if self.extremes.gradient > 0.0:
            limits["deformation"] = DEFORMATION_LIMIT / self.extremes.gradient
        cause = min(limits, key=lambda name: limits[name])
        return limits[cause], cause

    def expected_dt(self, breaking=False):
        """-> (step that a run takes about [s], what limits it)."""
        return self.stable_dt()

    def critical_dt(self):
        """-> (longest step that is not unstable [s], what limits it): none is."""
        return math.inf, "elastic"

    @property
    def limits(self):
        """`StepLimits`."""
        return StepLimits(self.cfl, self.critical_cfl, self.scheme_name, USUAL_ADVECTIVE)

    # ---- what acts on the particles ---------------------------------------------------------------------------

    def set_loads(self, loads):
        """loads: [(centre (dim,) [m, scene], radius [m], acceleration (dim,) [m/s2])] that act within their radius."""
        self._scene_loads = list(loads)

    def sever(self, line, radius, numbers, state):
        """Cut the bonds of particles (`Solver.sever`): what stress gave them is not what they have any more."""
        self._fresh = True
        return super().sever(line, radius, numbers, state)

    # ---- reading ----------------------------------------------------------------------------------------------

    @property
    def impulse(self):
        """Impulse that terrain, sides and loads gave [N s], (dim,)."""
        return self._loaded + self._held_impulse

    @property
    def totals(self):
        """`Totals` as they are now."""
        if not self._may_part:
            return super().totals
        return replace(super().totals, contact_lines=self.lines, contact_spared=self.spared)

    @property
    def obstacle_totals(self):
        """`PushesObstacles.obstacle_totals`; obstacles at rest take no work."""
        return np.pad(self._given, ((0, 0), (0, 1)))

    @property
    def memory(self):
        """Bytes of everything but the particles, about: stencils, tangents and the matrix of a step."""
        size = STENCILS[self.step_solver.grid.kernel].width ** self.dim
        a_particle = 8 * (size * (2 * self.dim + 3) + self.dim**4 + 40)
        neighbours = (2 * STENCILS[self.step_solver.grid.kernel].width - 1) ** self.dim
        nodes = self.particles.count / 2**self.dim
        return int(a_particle * self.particles.count + nodes * neighbours * (8 * self.dim**2 + 12))

    @property
    def workload(self):
        """`Workload` of a step."""
        return Workload(self.particles.n_blocks, components=self.adapters.work())

    def restart_clock(self):
        """Time zero is now: totals start again."""
        super().restart_clock()
        self._held_impulse[:] = 0.0
        self._given[:] = 0.0
        self.contact_work = 0.0
        self.lines, self.spared = 0, 0

    # ---- checkpoint -------------------------------------------------------------------------------------------

    def state(self):
        """All that a bitwise continuation needs, by name."""
        return {**super().state(), "acceleration": self._acceleration.copy(),
                "held_impulse": self._held_impulse.copy(), "fresh": self._fresh, "rubbed": self.contact_work,
                "given": self._given.copy(), "pressing": self._pressing.copy(),
                "contact_lines": self.lines, "contact_spared": self.spared}

    def restore(self, state):
        """Take over the `state()` of a solver of the same scene; loads are set apart.

        Raises InputError when it does not fit.
        """
        if state["acceleration"].shape != self._acceleration.shape:
            raise InputError("the particles of the checkpoint are not as many as those of the scene")
        super().restore(state)
        self._acceleration[:] = state["acceleration"]
        self._held_impulse[:], self._fresh = state["held_impulse"], bool(state["fresh"])
        if "given" in state:
            self._given[:], self._pressing[:] = state["given"], state["pressing"]
            self.contact_work = float(state["rubbed"])
        self.lines, self.spared = int(state.get("contact_lines", 0)), int(state.get("contact_spared", 0))
