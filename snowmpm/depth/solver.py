"""The depth-averaged method: columns of snow that move in plan over the ground.

A step is leapfrog, of second order and, without friction and shocks, symplectic:

    x <- x + dt/2 v;   columns -> nodes: depth, potential;   v <- v + dt a(x, v), then friction;   x <- x + dt/2 v
"""

import math
from dataclasses import asdict
from typing import Any

import numpy as np

from snowmpm.compiler import runtime, ti
from snowmpm.compiler.arrays import int_array, real_array
from snowmpm.compiler.parallel import runs_serially
from snowmpm.depth import gather, scatter
from snowmpm.depth.arrays import GroundArrays, NodeArrays, Segments, Tallies
from snowmpm.depth.blocks import DEEPER
from snowmpm.depth.columns import Columns
from snowmpm.depth.intake import Intake
from snowmpm.depth.nodes import NODE, TOTALS, Tiles, node_kernel
from snowmpm.depth.nodes import Step as NodeStep
from snowmpm.depth.plan_grid import MARGIN
from snowmpm.depth.plan_solver import WALLS, PlanSolver
from snowmpm.errors import InputError, SimulationError
from snowmpm.stepping.contract import Around, StepLimits, Totals, Workload
from snowmpm.stepping.setting import Setting
from snowmpm.stepping.time_step import Extremes

USUAL_CFL, CRITICAL_CFL = 0.5, 1.0
"""Cells that a wave crosses in a step: of a scene that gives none, and at most."""

USUAL_ADVECTIVE = 0.9
"""Cells that a column crosses in a step of a scene that gives no C: run-out, peaks and areas of an avalanche are the
same to 0.3 % with 0.25."""

COLUMN_STEP = 60e-9
"""Time of a step [s] a column on one thread, to choose how loops are handed out."""


class DepthSolver(PlanSolver, Around):
    """Columns of a population on a ground."""

    particles: Columns
    _start: Any

    def __init__(self, population, laws, options, *, friction, **setting):
        """friction: `ground.friction.GroundFriction`, or a law whose parameters are all numbers; setting: fields of
        `Setting`, of which the obstacles are those whose loads are wanted."""
        given = Setting(**setting)
        super().__init__(options, friction, given)
        self._load: Any = next((one.load for one in self.adapters if one.load), None)
        self.particles = Columns(population, laws, self.grid, self.bed, self.precision, self._load)
        self.cfl, self._advective = given.cfl or USUAL_CFL, given.cfl or USUAL_ADVECTIVE
        self._tables(population)
        self._gauge(given.obstacles, self.particles.mass, population)
        self.extremes = Extremes(float(np.linalg.norm(population.velocities, axis=1).max(initial=0.0)))
        self.time, self.steps, self.unconverged = 0.0, 0, 0
        self._wave = self._first_wave()
        self.adapters.begin(self)
        self.restart_clock()

    @classmethod
    def of(cls, population, laws, options, *, terrain_friction=None, **setting):
        """The solver of a scene (`snowmpm.methods.MethodEntry`)."""
        if setting["terrain"] is None:
            raise InputError('terrain: solver.method = "depth" needs a ground to flow over')
        if options.scheme == "volumes":
            from snowmpm.depth.volumes.solver import VolumeSolver

            return VolumeSolver(population, laws, options, friction=terrain_friction, **setting)
        return cls(population, laws, options, friction=terrain_friction, **setting)

    def _tables(self, population):
        """What kernels read beside the columns."""
        real = runtime.DTYPES[self.precision][0]
        grid, count = self.grid, max(1, self.particles.count)
        self._shared = runtime.fine_grained()
        load = self._load
        self._sets = load.sets if load else 1
        n_nodes = self._sets * grid.n_nodes
        copies, self.unit = 1 if self._shared else scatter.WORKERS, float(population.volumes.mean())
        sums, values, totals = (ti.Vector.ndarray(size, real, n) for size, n in (
            (scatter.TALLIES, copies * n_nodes), (load.node_size if load else NODE, n_nodes), (TOTALS, n_nodes)))
        for array in (sums, values, totals):
            array.fill(0.0)
        n_tiles = self._sets * grid.n_tiles
        self._tallies = Tallies(sums, int_array(np.zeros(copies * n_tiles)), copies, n_nodes, n_tiles, self.unit)
        self.nodes = NodeArrays(
            grid.lookup, values, totals, int_array(np.zeros(n_tiles)), real_array(grid.flat(self.bed.cos2)),
            int_array(grid.n_nodes * load.set_of if self._sets > 1 else np.zeros(1)))
        self._intake = next((make(self) for make in self.adapters.intake), None) or Intake.none(grid)
        walls = np.zeros((2, 4), int)
        for axis in (0, 1):
            walls[axis] = [*(name in WALLS for name in self._sides[axis]), grid.shape[axis],
                           grid.repeats[axis]]
        self._ground = GroundArrays(self.bed.table, self.bed.stride, int_array(self._place), real_array(self._numbers),
                                    int_array(walls))
        self._bounds: Any = None
        self._report: Any = ()
        self._serial = runs_serially(COLUMN_STEP * count)

    @property
    def shared(self):
        """Whether all threads add to the same nodes, by atomics."""
        return self._shared

    @property
    def serial(self):
        """Whether one thread takes all loops."""
        return self._serial

    def _shares(self):
        """Bounds of the segments of columns that each worker takes, and an empty report of them."""
        segments = max(1, -(-self.particles.rows // scatter.SEGMENT))
        if len(self._report) != segments:
            workers = segments if self._shared else min(segments, scatter.WORKERS)
            self._bounds = int_array(np.linspace(0, segments, workers + 1).round())
            self._report = np.zeros((segments, gather.REPORT))
        return self._bounds, self._report

    # ---- the step ---------------------------------------------------------------------------------------------

    def step(self, dt):
        """Advance by dt [s]."""
        store, grid, cover, options = self.particles, self.grid, self._intake, self.options
        real, g = runtime.DTYPES[self.precision][0], -float(self.gravity[2])
        bounds, report = self._shares()
        columns, nodes, tallies = store.arrays, self.nodes, self._tallies
        with runtime.precision(self.precision):
            scatter.scatter_kernel(real, self._shared, cover.law is not None, self._serial, self._sets)(
                columns, nodes, tallies, bounds, 0.5 * dt, 1.0 / grid.dx, store.rows)
            sizes = grid.n_tiles, *grid.tiles.tolist()[1:], *grid.shape.tolist()
            for number in range(self._sets):  # one after the other, since all may take from the same snow cover
                node_kernel(real, cover.law is not None, self._serial)(
                    tallies, nodes, cover.arrays, self.bed.table,
                    NodeStep(g, grid.dx, options.damping, options.mixing, dt), Tiles(number * grid.n_tiles, *sizes))
            for act in self.adapters.after_scatter:
                act(dt, dt)
            load = self._load
            kind: Any = type(load) if load else None
            gather.gather_kernel(real, self._law, cover.law, kind, self._serial)(
                columns, nodes, self._ground, cover.arrays, load.numbers if load else self._ground.friction,
                Segments(bounds, report, store.flowing),
                gather.Step(dt, 1.0 / grid.dx, g, float(options.centrifugal)))
            for act in self.adapters.after_gather:
                act(dt)
            if self._gauges:
                self._gauges.feel_nodes(nodes.totals, self.unit, dt)
        store.changed()
        self._read(report)
        self.weight_impulse += dt * store.mass * self.gravity
        if cover.law:
            store.gain(report[:, gather.TAKEN_UP].sum(), report[:, gather.HEIGHT].sum(), self.gravity)
        self.time += dt
        self.steps += 1
        if report[:, gather.LEFT].any():
            self.particles.take(self._inside(), self.gravity)
        for act in self.adapters.end_step:
            act(dt)
        if store.release(self.time):
            self._wave = max(self._wave, self._first_wave())

    def _read(self, report):
        speed2, wave2 = report[:, gather.SPEED2].max(), report[:, gather.WAVE2].max()
        if not np.isfinite(speed2 + report[:, gather.FRICTION_WORK].sum()):
            self._fail()
        self.extremes, self._wave = Extremes(speed=math.sqrt(speed2)), math.sqrt(wave2)
        self.contact_work += report[:, gather.FRICTION_WORK].sum()
        self._plan_impulse += report[:, gather.IMPULSE : gather.IMPULSE + 2].sum(axis=0)

    def _fail(self):
        """Raise SimulationError, with the first column whose numbers are not finite."""
        table = self.particles.reals.to_numpy()[: self.particles.count]
        bad = np.flatnonzero(~np.isfinite(table).all(axis=1))
        which = f"column {self.particles.identity.to_numpy()[bad[0]]}" if len(bad) else "a column"
        raise SimulationError(f"{which} has no finite velocity, at t = {self.time:.6g} s, step {self.steps}:\n"
                              "lower solver.cfl or check the friction of the ground")

    def _inside(self):
        """Whether each column is over ground, inside the domain (n,). SimulationError: one went further in a step than
        what is known of the ground beyond the sides."""
        cells = self.particles.cells.to_numpy()[: self.particles.count]
        beyond = np.maximum(-cells, cells - self.grid.shape + 1).max(axis=1)
        if (beyond >= MARGIN).any():
            which = self.particles.identity.to_numpy()[np.argmax(beyond)]
            raise SimulationError(f"column {which} went more than {MARGIN} cells beyond the domain in one step, at t ="
                                  f" {self.time:.6g} s, step {self.steps}:\nlower solver.cfl, or look for what pushes"
                                  " it, such as a snow cover thicker than the flow")
        inside = ((cells >= 0) & (cells < self.grid.shape)).all(axis=1)
        inside[inside] = ~self.bed.holes[tuple(cells[inside].T)]
        return inside

    # ---- its length -------------------------------------------------------------------------------------------

    def _first_wave(self):
        """c [m/s] of the columns as they are."""
        store = self.particles
        if store.count == 0:
            return 0.0
        return math.sqrt(-self.gravity[2] * float(store.snapshot().surface().max(initial=0.0)))

    def _longest(self, share, advective, speed=None):
        """dt and cause, with which a wave crosses at most `share` cells, and a column that speeds up with g at most
        `advective`; speed [m/s]: of the fastest, that of the last step when missing."""
        g, way = -float(self.gravity[2]), advective * self.grid.dx
        speed = self.extremes.speed if speed is None else speed
        advective = 2.0 * way / max(speed + math.sqrt(speed**2 + 2.0 * g * way), 1e-30)
        elastic = share * self.grid.dx / max(self._wave, 1e-30)
        return (elastic, "elastic") if elastic < advective else (advective, "advective")

    def stable_dt(self):
        """-> (step for now [s], what limits it)."""
        return self._longest(self.cfl, self._advective)

    def critical_dt(self):
        """-> (longest stable step [s], what limits it)."""
        return self._longest(CRITICAL_CFL, CRITICAL_CFL)

    def expected_dt(self, breaking=False):
        """-> (step that a run takes about [s], what limits it): the one for now."""
        return self.stable_dt()

    def course(self, end_time, interval):
        """`Course` of a run from now, by blocks that slide down from where columns are."""
        store, share = self.particles, self.cfl / math.sqrt(DEEPER)
        return self._course(store.density, lambda speed: self._longest(share, self._advective, speed)[0],
                            float(store.starts[-1]) if store.count else 0.0, end_time, interval,
                            self._load and self._load.share)

    @property
    def limits(self):
        """`StepLimits`."""
        return StepLimits(self.cfl, CRITICAL_CFL, "depth-averaged flow", USUAL_CFL)

    # ---- what acts on the columns -----------------------------------------------------------------------------

    def receive(self, population, numbers):
        """Take in a `Population` with numbers (n,) that no column has yet."""
        store, before = self.particles, self.particles.momentum()
        store.add(population, numbers)
        self._start = self._start + self.particles.momentum() - before
        self.extremes = Extremes(speed=max(self.extremes.speed, float(
            np.linalg.norm(population.velocities, axis=1).max(initial=0.0))))
        self._wave = self._wave or self._first_wave()

    def invite(self, population):
        """Let a `Population` press on the columns in the next step."""
        self.particles.invite(population)

    def pull(self, plan):
        """Acceleration (k, 3) [m/s2] that the depth of the columns gives snow at places in plan (k, 2) [m]."""
        return self.particles.snapshot().pull(plan, -float(self.gravity[2]))

    def remove(self, gone):
        """Take columns out."""
        self.particles.take(~np.asarray(gone, bool), self.gravity, taken=True)

    def restart_clock(self):
        """Time zero is now: totals start again."""
        self.time, self.steps, self.contact_work = 0.0, 0, 0.0
        self._plan_impulse, self.weight_impulse = np.zeros(2), np.zeros(3)
        self._start = self.particles.momentum() + self.particles.removed["momentum"]
        for one in self.adapters:
            one.restart()

    # ---- reading ----------------------------------------------------------------------------------------------

    @property
    def totals(self):
        """`Totals` as they are now. The ground gives vertically what keeps the snow on it."""
        gone = self.particles.removed["momentum"]
        vertical = self.particles.momentum()[2] + gone[2] - self._start[2] - self.weight_impulse[2]
        return Totals(np.append(self._plan_impulse, vertical), self.weight_impulse.copy(), np.zeros(3), 0.0,
                      self.contact_work)

    @property
    def workload(self):
        """`Workload` of a step."""
        return Workload(self.particles.n_blocks, components=self.adapters.work())

    @property
    def memory(self):
        """Bytes of everything but the columns."""
        grid, real = self.grid, 4 if self.precision == "f32" else 8
        return (grid.n_nodes * (self._tallies.copies * real * scatter.TALLIES + NODE * real + 8 + 4)
                + self.bed.table.shape[0] * 8 + self.adapters.bytes)

    # ---- checkpoint -------------------------------------------------------------------------------------------

    def state(self):
        """All that a bitwise continuation needs, by name."""
        return {"columns": self.particles.state(), "frame": self.frame.bounds, "extremes": asdict(self.extremes),
                "wave": self._wave, "time": self.time, "steps": self.steps, "contact_work": self.contact_work,
                "plan_impulse": self._plan_impulse.copy(), "weight_impulse": self.weight_impulse.copy(),
                "start": self._start.copy(), "gauges": self._gauges.state() if self._gauges else {},
                **({"components": self.adapters.state()} if self.adapters else {}),
                "ground": self.bed.table.to_numpy() if self.adapters.move_ground else np.zeros(0)}

    def restore(self, state):
        """Take over the `state()` of a solver of the same scene. Raises InputError when it does not fit."""
        self.frame.check(state["frame"])
        self.particles.restore(state["columns"])
        self.extremes, self._wave = Extremes(**state["extremes"]), state["wave"]
        self.time, self.steps, self.contact_work = state["time"], state["steps"], state["contact_work"]
        self._plan_impulse = np.array(state["plan_impulse"])
        self.weight_impulse, self._start = np.array(state["weight_impulse"]), np.array(state["start"])
        if self.adapters:
            self.adapters.restore(state["components"])
        if self._gauges:
            self._gauges.restore(state["gauges"])
        if self.adapters.move_ground:
            self.bed.table.from_numpy(np.ascontiguousarray(state["ground"]))
