"""What methods of particles among surfaces share: a clock, totals, loads, settling, limits of a step, their state."""

from dataclasses import asdict, replace
from typing import Any

import numpy as np

from snowmpm.compiler import runtime
from snowmpm.compiler.arrays import real_array
from snowmpm.errors import SimulationError
from snowmpm.particles.sorted_particles import SortedParticles
from snowmpm.stepping import step_report
from snowmpm.stepping.contract import (
    Affine,
    Forecasts,
    Method,
    PushesObstacles,
    Removes,
    Settles,
    Severs,
    StepLimits,
    TakesLoads,
    Totals,
    Workload,
)
from snowmpm.stepping.time_step import (
    BREAKING_SHARE,
    FLIGHT_LIMIT,
    STRAINED_SHARE,
    Extremes,
    stable_step,
    strained_cfl,
)


class Solver(Method, TakesLoads, Removes, PushesObstacles, Affine, Forecasts):
    """Base of `mpm.solver.MpmSolver` and `sph.solver.SphSolver`, which add the step, contact and what goes with them.

    particles: `SortedParticles`. Totals since the start: `impulse` of terrain, sides and loads and `weight_impulse`
    [N s], `plastic_work` [J], `unconverged` return maps; `momentum_gain` [N s2], the time integral of all momentum that
    came in, where the domain is periodic; n_plastic: particles that yielded in the last step. damping_factor: share of
    the velocity that is left after each step, below 1 only while an initial state settles.

    A solver sets `dim`, `dx`, `precision`, `frame`, `surfaces`, `particles`, `critical_cfl`, `usual_cfl` of a scene
    that gives none, `cfl` and `breaking_cfl`, the C of its steps while no bonds break and while some do, and
    `scheme_name`, then calls `_begin`.
    """

    particles: SortedParticles
    dim: int
    dx: float
    precision: str
    surfaces: Any
    cfl: float
    critical_cfl: float
    scheme_name: str
    contact_work: Any
    """[J]; a number, or a property that adds up"""
    _pushing_speed: Any
    """of the fastest obstacle [m/s]"""
    damping_factor: float
    usual_cfl: Any = None
    breaking_cfl: Any = None
    advective_cfl: float | None = None
    """None of a method whose steps do not follow the state."""

    BAD = ""
    """What a particle that ended the simulation did, for the message."""

    DAMPED_IMPULSE = True
    """Whether terrain and sides carry what damping leaves, while an initial state settles, or all that there was."""

    def _begin(self, population, gravity):
        """Time zero: nothing has happened yet."""
        self.materials = self.particles.materials
        self.gravity = np.asarray(gravity, float)
        self._gravity = real_array(self.gravity)
        deviation, wave_speed = self.materials.first_extremes(population)
        self.extremes = Extremes(speed=float(np.linalg.norm(population.velocities, axis=1).max(initial=0.0)),
                                 elastic_deviation=deviation, wave_speed=wave_speed)
        self.time, self.steps, self.damping_factor = 0.0, 0, 1.0
        self._many_break = BREAKING_SHARE * self.materials.n_bonded(population.material)
        self._loaded, self.weight_impulse, self.momentum_gain = (np.zeros(self.dim) for _ in range(3))
        self.plastic_work, self.unconverged, self.n_plastic = 0.0, 0, 0
        self.set_loads([])

    def shorten_steps(self, share):
        """Keep the C of a scene that gives none to this share of the critical one."""
        self.cfl = self.usual_cfl = min(self.cfl, share * self.critical_cfl)
        self.breaking_cfl = min(self.breaking_cfl, self.cfl)

    def set_gravity(self, gravity):
        """Gravity (dim,) [m/s2] of the steps to come."""
        self.gravity = np.asarray(gravity, float)
        self._gravity.from_numpy(self.gravity)

    def _act(self, dt):
        """What acts beside stress and contact, before a step; -> the time for which forces act in it [s]."""
        pushed = dt
        for act in self.adapters.before_step:
            pushed = act(dt, pushed)
        return pushed

    def _advance_clock(self, dt, pushed):
        """After a step of dt [s] in which forces acted for the time `pushed` [s]."""
        if self.adapters.after_step:
            with runtime.precision(self.precision):
                for act in self.adapters.after_step:
                    act(dt)
        self.weight_impulse += pushed * self.particles.mass * self.gravity
        for act in self.adapters.end_step:
            act(dt)
        if self.particles.repeats.any():
            self.momentum_gain += dt * (self.weight_impulse + self.impulse - self.particles.removed["momentum"])
        self.time += dt
        self.steps += 1

    @property
    def impulse(self):
        """Impulse that terrain, sides and loads gave [N s], (dim,)."""
        return self._loaded + sum((surface.total[: self.dim] for surface in self.surfaces), np.zeros(self.dim))

    @property
    def totals(self):
        """`Totals` as they are now."""
        return Totals(self.impulse, self.weight_impulse.copy(), self.momentum_gain.copy(), self.plastic_work,
                      self.contact_work, self.n_plastic)

    # ---- the step ---------------------------------------------------------------------------------------------

    @property
    def limits(self):
        """`StepLimits`."""
        return StepLimits(self.cfl, self.critical_cfl, self.scheme_name, self.usual_cfl)

    def stable_dt(self):
        """-> (step for now [s], what limits it), with the margin of cfl; "breaking": elastic, but bonds break."""
        careful = self.cfl if self.breaking_cfl is None else self.breaking_cfl
        breaks = careful < self.cfl and self.extremes.breaking > self._many_break
        elastic = careful if breaks else strained_cfl(self.cfl, careful, self.extremes.elastic_deviation,
                                                      self.extremes.strained)
        dt, cause = self._step_at(elastic, self.advective_cfl or self.cfl)
        return dt, "breaking" if breaks and cause == "elastic" else cause

    def expected_dt(self, breaking=False):
        """-> (step that a run takes about [s], what limits it): the one for now, at small strains."""
        short = breaking and self.breaking_cfl is not None
        return self._step_at(self.breaking_cfl if short else self.cfl, self.advective_cfl or self.cfl)

    def critical_elastic_dt(self):
        """Longest step that waves in the skeleton allow now [s]."""
        still = replace(self.extremes, speed=0.0, gradient=0.0)
        return stable_step(self.dx, self.critical_cfl, FLIGHT_LIMIT, self.materials.fastest_wave, still)[0]

    def critical_dt(self):
        """-> (longest step that is not unstable [s], what limits it)."""
        return self._step_at(self.critical_cfl, FLIGHT_LIMIT)

    def _step_at(self, elastic, advective):
        extremes = self.extremes
        if (pushing := self._pushing_speed) > extremes.speed:
            extremes = replace(extremes, speed=pushing)
        if (faster := self.adapters.wave_speed) > extremes.wave_speed:
            extremes = replace(extremes, wave_speed=faster)
        return stable_step(self.dx, elastic, advective, self.materials.fastest_wave, extremes)

    def _read(self, report):
        """Take in the report of a step (`snowmpm.stepping.step_report`).

        Raises SimulationError for a particle that is not finite any more.
        """
        report = report.tolist()  # Python's numbers are several times faster, one by one
        if report[step_report.BAD]:
            self._fail(int(report[step_report.BAD]) - 1)
        many_strained = step_report.PARTS * STRAINED_SHARE * max(self.particles.count, 1)
        self.extremes = Extremes(speed=report[step_report.SPEED2] ** 0.5, gradient=report[step_report.GRADIENT2] ** 0.5,
                                 elastic_deviation=report[step_report.STRAIN] ** 0.5,
                                 strained=min(1.0, report[step_report.STRAINED] / many_strained),
                                 wave_speed=report[step_report.WAVE2] ** 0.5,
                                 breaking=int(report[step_report.BREAKING]))
        self.plastic_work += report[step_report.DISSIPATION]
        self.unconverged += int(report[step_report.UNCONVERGED])
        self.n_plastic = int(report[step_report.PLASTIC])

    def _fail(self, row):
        particle, place = self.particles.describe(row)
        raise SimulationError(f"{particle} {self.BAD}, at t = {self.time:.6g} s, step {self.steps}, {place}:\n"
                              "lower solver.cfl or check the stiffness of its material")

    @property
    def workload(self):
        """`Workload` of a step."""
        return Workload(self.particles.n_blocks, components=self.adapters.work())

    # ---- what the particles carry, and what obstacles get ------------------------------------------------------

    def second_moment(self):
        """D [m2] of the affine motion; 0 where particles carry none."""
        return 0.0

    def null_space_noise(self, energy):
        """Share of the kinetic energy [J] that no grid sees."""
        return 0.0

    @property
    def obstacle_totals(self):
        """Of no obstacle."""
        return np.zeros((0, self.dim + (1 if self.dim == 2 else 3) + 1))

    def remove(self, gone):
        """Take particles out, `gone` (n,) true; they count as removed."""
        self.particles.remove(gone)

    # ---- loads ------------------------------------------------------------------------------------------------

    def set_loads(self, loads):
        """loads: [(centre (dim,) [m, scene], radius [m], acceleration (dim,) [m/s2])] that act within their radius."""
        rows = [[*((np.asarray(centre) - self.frame.origin) / self.dx), radius / self.dx, *acceleration]
                for centre, radius, acceleration in loads]
        self._n_loads = len(rows)
        self.load_rows = np.array(rows)
        self._loads = real_array(rows or [[0.0] * (2 * self.dim + 1)])

    def push(self, numbers, gain, mass):
        """Add `gain` (dim,) [m/s] to the velocity of the particles numbers[0] <= number < numbers[1], whose mass is
        `mass` [kg]; counts as a load."""
        self.particles.push(numbers, gain)
        self.add_impulse(mass * np.asarray(gain))

    def add_impulse(self, impulse):
        """Count an impulse (dim,) [N s] that a load gave the particles."""
        self._loaded += impulse

    # ---- clock and totals -------------------------------------------------------------------------------------

    def restart_clock(self):
        """Time zero is now: totals start again."""
        self.time, self.steps, self.plastic_work, self.unconverged = 0.0, 0, 0.0, 0
        self._loaded[:], self.weight_impulse[:], self.momentum_gain[:] = 0.0, 0.0, 0.0
        for one in self.adapters:
            one.restart()

    def state(self):
        """Particles, blocks, clock and totals by name; a method adds its own."""
        return {
            **self.particles.state(), "frame": self.frame.bounds, "extremes": asdict(self.extremes), "time": self.time,
            "steps": self.steps, "loaded": self._loaded.copy(), "weight_impulse": self.weight_impulse.copy(),
            "momentum_gain": self.momentum_gain.copy(),
            "plastic_work": self.plastic_work, "unconverged": self.unconverged, "n_plastic": self.n_plastic,
            **({"components": self.adapters.state()} if self.adapters else {}),
        }

    def restore(self, state):
        """Take over the `state()` of a solver of the same scene; loads are set apart.

        Raises InputError when it does not fit.
        """
        self.frame.check(state["frame"])
        self.particles.restore(state)
        self.extremes = Extremes(**state["extremes"])
        self.time, self.steps = state["time"], state["steps"]
        self._loaded[:], self.weight_impulse[:] = state["loaded"], state["weight_impulse"]
        self.momentum_gain[:] = state.get("momentum_gain", 0.0)
        self.plastic_work, self.unconverged = state["plastic_work"], state["unconverged"]
        self.n_plastic = state["n_plastic"]
        if self.adapters:
            self.adapters.restore(state["components"])


class Severing(Severs):
    """Of a `Solver` whose particles have bonds."""

    particles: SortedParticles

    def sever(self, line, radius, numbers, state):
        """Cut the bonds of the particles numbers[0] <= number < numbers[1] within `radius` [m] of a line in plan: no
        stress, and the law's severed `state`; -> how many."""
        return self.particles.sever(line, radius, numbers, state)


class Damped(Settles):
    """Of a `Solver` that comes to rest by damped steps."""

    damping_factor: float
    DAMPED_IMPULSE: bool

    def damp(self, kept):
        """Keep the share `kept` of all velocities in each step from now on; 1 ends it. -> the share of the impulses of
        terrain and sides that totals count."""
        if kept < 1.0 and self.damping_factor == 1.0:
            self._begin_damping()
        elif kept == 1.0 and self.damping_factor < 1.0:
            self._end_damping()
        self.damping_factor = kept
        return kept if self.DAMPED_IMPULSE else 1.0

    def _begin_damping(self):
        """Before the first damped step."""

    def _end_damping(self):
        """After the last one."""
