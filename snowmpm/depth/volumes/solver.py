"""Depth-averaged flow by finite volumes: `kernels` over the cells of a plan grid."""

import math
from dataclasses import asdict
from typing import Any

import numpy as np

from snowmpm.compiler import runtime
from snowmpm.compiler.parallel import runs_serially
from snowmpm.depth.intake import Intake
from snowmpm.depth.plan_grid import MARGIN
from snowmpm.depth.plan_solver import WALLS, PlanSolver
from snowmpm.depth.volumes import arrays
from snowmpm.depth.volumes.cells import FlowCells
from snowmpm.depth.volumes.kernels import kernels
from snowmpm.depth.volumes.live import LiveTiles
from snowmpm.depth.volumes.planes import shape_kernel
from snowmpm.errors import SimulationError
from snowmpm.stepping.contract import StepLimits, Totals, Workload
from snowmpm.stepping.setting import Setting
from snowmpm.stepping.time_step import Extremes

USUAL_CFL, CRITICAL_CFL = 0.8, 1.0
"""Sum over both axes of what waves and snow cross of a cell in a step: usual, and at most."""

ALONG = 1.0
"""Sum of a velocity's parts along both axes in plan over the speed along the ground, about: 1.27 in the mean of all
directions, times the cosine of a slope."""

THINNER = 0.5
"""Speed of waves on a flow over that on the release, about: flows thin to a quarter."""

CELL_STEP = 200e-9
"""Time of a step [s] a cell on one thread."""


class VolumeSolver(PlanSolver):
    """Snow of one material that flows over a ground, in cells."""

    particles: FlowCells
    _start: Any

    def __init__(self, population, laws, options, *, friction, **setting):
        """Arguments as of `depth.solver.DepthSolver`. Raises InputError for what this scheme does not compute."""
        given = Setting(**setting)
        super().__init__(options, friction, given)
        self.particles = FlowCells(population, laws, self.grid, self.precision)
        self.cfl = given.cfl or USUAL_CFL
        self._tables()
        self._mass = self.particles.mass
        self._gauge(given.obstacles, self._mass, population)
        if self._gauges:
            nodes = self.grid.nodes()
            cell = np.zeros((self.grid.n_nodes, 2), int)
            cell[nodes] = np.moveaxis(np.indices(nodes.shape), 0, -1) + MARGIN
            self._gauged = tuple(cell[self._gauges.nodes].T)
        self.extremes = Extremes(float(np.linalg.norm(population.velocities, axis=1).max(initial=0.0)))
        self.time, self.steps, self.unconverged = 0.0, 0, 0
        self.adapters.begin(self)
        self.restart_clock()
        self._look()

    def _tables(self):
        """What kernels read."""
        store, grid, real = self.particles, self.grid, self.real_numpy
        nx, ny = store.state_array.shape[:2]
        n = nx * ny
        ahead, slopes, flux = (np.zeros((n, *shape), real) for shape in ((3,), (arrays.SLOPES,), (2, arrays.FLUX)))
        self._cells = arrays.Cells(store.state_array.reshape(n, 3), np.ones(n, np.int32), np.ones(n, real), ahead,
                                  slopes, flux, store.ground.reshape(n, arrays.GROUND))
        node = np.pad(grid.nodes(), MARGIN, mode="edge")
        self._friction = arrays.Friction(np.ascontiguousarray(node.ravel(), np.int32), self._place.astype(np.int32),
                                        np.ascontiguousarray(self._numbers), store.density)
        self._at_first = np.array(self.bed.plain)
        self.heights = self._at_first.copy()
        """Heights (nx + 2 MARGIN, ny + 2 MARGIN) [m] of the ground under the middles of the cells as they are now."""
        store.heights = self.heights
        self._heights = self.heights.ravel()
        self._intake = next((make(self) for make in self.adapters.intake), None) or Intake.none(grid)
        self._serial = runs_serially(CELL_STEP * max(1, int((store.state_array[..., 0] > 0.0).sum())))
        outside = np.zeros((nx, ny), bool)
        FlowCells.inner(outside)[:] = self.bed.holes
        for axis in (0, 1):
            for end, part in ((0, slice(0, MARGIN)), (1, slice(-MARGIN, None))):
                if self._sides[axis][end] not in (*WALLS, "periodic"):
                    np.moveaxis(outside, axis, 0)[part] = True
        self._live = LiveTiles(store, outside, (ahead, slopes, flux))
        self._tiles = self._live.tiles
        self._report = np.zeros((self._tiles.n, arrays.REPORT))
        self._shape()
        store.find_origins()

    @property
    def real_numpy(self):
        """NumPy type of its numbers."""
        return runtime.DTYPES[self.precision][1]

    def _kernels(self):
        return kernels(self.real, self._law, self._intake.law, self._serial)

    def _shape(self):
        """The ground of live tiles, from `heights`."""
        for axis in (0, 1):
            for end in (0, 1):
                if self._sides[axis][end] in WALLS:
                    self._one_side(self.heights, axis, end, lambda part, along: part)
                elif self._sides[axis][end] == "periodic":  # the ground goes on there, and what changed it comes again
                    changes = self.heights - self._at_first
                    self._one_side(changes, axis, end, lambda part, along: part)
                    beyond = slice(0, MARGIN) if end == 0 else slice(self.grid.shape[axis] + MARGIN, None)
                    ground, first, change = (np.moveaxis(array, axis, 0)[beyond]
                                             for array in (self.heights, self._at_first, changes))
                    np.add(first, change, out=ground)
        with runtime.precision(self.precision):
            shape_kernel(self.real, self._serial)(self._cells, self._heights, self._tiles, self.grid.dx)

    # ---- the step ---------------------------------------------------------------------------------------------

    def step(self, dt):
        """Advance by dt [s]."""
        self._beyond()  # first, so that snow at one end of a periodic axis wakes the other
        self._live.wake()
        if self.adapters.move_ground:
            self._shape()
        step = arrays.Step(dt, self.grid.dx, -float(self.gravity[2]), float(self.options.centrifugal))
        cover, launch = self._intake.arrays, self._kernels()
        self._report[:] = 0.0
        with runtime.precision(self.precision):
            launch.rub(self._cells, self._friction, cover, self._tiles, step, self._report)
            self._beyond()
            launch.predict(self._cells, self._tiles, step)
            self._mirror_ahead()
            launch.cross(self._cells, self._tiles, step)
            launch.drain(self._cells, self._tiles, step)
            self._fill(self._cells.share.reshape(*self.particles.state_array.shape[:2], 1), (None, None))
            launch.update(self._cells, self._friction, cover, self._heights, self._tiles, step, self._report)
        if self._gauges:
            state = self.particles.state_array[self._gauged].astype(float) * [self.grid.dx**2, 1.0, 1.0]
            self._gauges.feel(state[:, :1] * np.column_stack([np.ones(len(state)), state[:, 1:]]), dt)
        self._lose()
        self._read()
        self.particles.changed()
        if self._intake.law:
            self._gain()
        self.weight_impulse += dt * self._mass * self.gravity
        self.time += dt
        self.steps += 1
        for act in self.adapters.end_step:
            act(dt)
        if self.adapters.changed_mass:
            self._mass = self.particles.mass
        if self.particles.release(self.time):
            self.particles.changed()
            self._look()
            self._live.everywhere()

    def _gain(self):
        """Count the snow cover that was taken up."""
        removed = self.particles.removed
        removed["entrained"] += float(self._report[:, arrays.TAKEN_UP].sum())
        removed["energy"] += float(self._report[:, arrays.HEIGHT].sum()) * self.gravity[2]

    def _beyond(self):
        """Cells beyond the sides: the mirror image at walls, the other end of periodic axes."""
        self._fill(self.particles.state_array, (1, 2))

    def _mirror_ahead(self):
        nx, ny = self.particles.state_array.shape[:2]
        self._fill(self._cells.ahead.reshape(nx, ny, 3), (1, 2))
        slopes = self._cells.slopes.reshape(nx, ny, 2, 3)
        for axis in (0, 1):
            for end in (0, 1):
                self._one_side(slopes, axis, end, lambda part, along: _turned_slopes(part, along))

    def _fill(self, array, velocities):
        for axis in (0, 1):
            for end in (0, 1):
                self._one_side(array, axis, end, lambda part, along: _turned(part, velocities[along]))

    def _one_side(self, array, axis, end, turned):
        """Fill what lies beyond one side of an array (nx, ny, ...) from within."""
        name = self._sides[axis][end]
        view = np.moveaxis(array, axis, 0)
        n = self.grid.shape[axis]
        if name == "periodic":
            if end == 0:
                view[:MARGIN] = view[n : n + MARGIN]
            else:
                view[n + MARGIN :] = view[MARGIN : 2 * MARGIN]
        elif name in WALLS:
            if end == 0:
                view[:MARGIN] = turned(view[MARGIN : 2 * MARGIN][::-1], axis)
            else:
                view[n + MARGIN :] = turned(view[n : n + MARGIN][::-1], axis)

    def _lose(self):
        """Snow that left over an open side, or came to cells without ground, is gone."""
        state, grid = self.particles.state_array, self.grid
        for axis in (0, 1):
            for end, part in ((0, slice(0, MARGIN)), (1, slice(grid.shape[axis] + MARGIN, None))):
                if self._sides[axis][end] in (*WALLS, "periodic"):
                    np.moveaxis(state, axis, 0)[part] = 0.0
        lost = self._live.lost()
        if len(lost):
            rows = state.reshape(-1, 3)
            mass = rows[lost, 0].astype(float) * grid.dx**2 * self.particles.density
            plan = rows[lost, 1:].astype(float)
            ground = self.particles.ground.reshape(len(rows), -1)[lost, :2]
            velocity = np.column_stack([plan, (plan * ground).sum(axis=1)])
            removed = self.particles.removed
            removed["mass"] += float(mass.sum())
            removed["momentum"] = removed["momentum"] + mass @ velocity
            removed["energy"] += float(mass @ (0.5 * (velocity**2).sum(axis=1)
                                               - self.gravity[2] * self.particles.heights.ravel()[lost]))
            rows[lost] = 0.0
            self._mass = self.particles.mass

    def _read(self):
        speed2 = float(self._report[:, arrays.SPEED2].max())
        work = float(self._report[:, arrays.WORK].sum())
        if not np.isfinite(speed2 + work):
            self._fail()
        self.extremes = Extremes(speed=math.sqrt(speed2))
        self.contact_work += work * self.particles.density * self.grid.dx**2
        self._rate = float(self._report[:, arrays.RATE].max())

    def _fail(self):
        bad = np.argwhere(~np.isfinite(FlowCells.inner(self.particles.state_array)).all(axis=2))
        where = f"cell ({bad[0][0]}, {bad[0][1]})" if len(bad) else "a cell"
        raise SimulationError(f"{where} has no finite depth or velocity, at t = {self.time:.6g} s, step {self.steps}:\n"
                              "lower solver.cfl or check the friction of the ground")

    def _waves(self):
        """Sum of the speeds of waves along both axes [m/s], of each cell with snow."""
        store = self.particles
        depth, ground = (FlowCells.inner(array).astype(float) for array in (store.state_array[..., 0], store.ground))
        depth, ground = depth[depth > 0.0], ground[depth > 0.0]
        return np.sqrt(-self.gravity[2] * depth) * ground[:, 5] ** 2 * np.sqrt(1.0 + ground[:, :2] ** 2).sum(axis=1)

    def _look(self):
        """The largest rate at which cells are crossed, of the snow as it is."""
        state = FlowCells.inner(self.particles.state_array)
        plan = np.abs(state[state[..., 0] > 0.0][:, 1:].astype(float)).sum(axis=1)
        self._rate = float((plan + self._waves()).max(initial=0.0)) / self.grid.dx

    # ---- its length -------------------------------------------------------------------------------------------

    def _longest(self, share, speed=None):
        """dt and cause: snow that speeds up with g crosses at most `share` of a cell. speed [m/s]: of the fastest waves
        and snow, of the last step when missing."""
        g, way = -float(self.gravity[2]), share * self.grid.dx
        speed = max(self._rate * self.grid.dx if speed is None else speed, 1e-30)
        dt = 2.0 * way / (speed + math.sqrt(speed**2 + 2.0 * g * way))
        return dt, "advective" if self.extremes.speed > 0.5 * speed else "elastic"

    def stable_dt(self):
        """-> (step for now [s], what limits it)."""
        return self._longest(self.cfl)

    def critical_dt(self):
        """-> (longest stable step [s], what limits it)."""
        return self._longest(CRITICAL_CFL)

    def expected_dt(self, breaking=False):
        """-> (step that a run takes about [s], what limits it): the one for now."""
        return self.stable_dt()

    def course(self, end_time, interval):
        """`Course` of a run from now, by blocks that slide down from where the snow is."""
        store, waves = self.particles, THINNER * float(self._waves().max(initial=0.0))
        return self._course(store.materials.density, lambda speed: self._longest(self.cfl, ALONG * speed + waves)[0],
                            max((start for start, _ in store.later), default=0.0), end_time, interval)

    @property
    def limits(self):
        """`StepLimits`."""
        return StepLimits(self.cfl, CRITICAL_CFL, "depth-averaged flow by finite volumes", USUAL_CFL)

    def restart_clock(self):
        """Time zero is now: totals start again."""
        self.time, self.steps, self.contact_work = 0.0, 0, 0.0
        self.weight_impulse = np.zeros(3)
        self._start = self.particles.momentum() + self.particles.removed["momentum"]
        for one in self.adapters:
            one.restart()

    # ---- reading ----------------------------------------------------------------------------------------------

    @property
    def totals(self):
        """`Totals` as they are now: all that changes the momentum, but for the weight, comes from the ground."""
        given = self.particles.momentum() + self.particles.removed["momentum"] - self._start - self.weight_impulse
        return Totals(given, self.weight_impulse.copy(), np.zeros(3), 0.0, self.contact_work)

    @property
    def workload(self):
        """`Workload` of a step."""
        return Workload(self.particles.n_blocks, components=self.adapters.work())

    @property
    def memory(self):
        """Bytes of everything but the cells with snow."""
        friction = self._friction
        held = *self._cells, friction.node, friction.place, friction.numbers, self._heights
        return sum(array.nbytes for array in held) + self.adapters.bytes

    # ---- checkpoint -------------------------------------------------------------------------------------------

    def state(self):
        """All that a bitwise continuation needs, by name."""
        return {"cells": self.particles.state(), "frame": self.frame.bounds, "extremes": asdict(self.extremes),
                "rate": self._rate, "time": self.time, "steps": self.steps, "contact_work": self.contact_work,
                "weight_impulse": self.weight_impulse.copy(), "start": self._start.copy(),
                "gauges": self._gauges.state() if self._gauges else {},
                **({"components": self.adapters.state()} if self.adapters else {}),
                "ground": self.heights.copy() if self.adapters.move_ground else np.zeros(0), "mass": self._mass}

    def restore(self, state):
        """Take over the `state()` of a solver of the same scene. Raises InputError when it does not fit."""
        self.frame.check(state["frame"])
        self.particles.restore(state["cells"])
        self._mass = state["mass"]
        self._live.everywhere()
        self.extremes, self._rate = Extremes(**state["extremes"]), state["rate"]
        self.time, self.steps, self.contact_work = state["time"], state["steps"], state["contact_work"]
        self.weight_impulse, self._start = np.array(state["weight_impulse"]), np.array(state["start"])
        if self.adapters:
            self.adapters.restore(state["components"])
        if self._gauges:
            self._gauges.restore(state["gauges"])
        if self.adapters.move_ground:
            self.heights[:] = state["ground"]
            self._live.all_live()
            self._shape()


def _turned(part, velocity):
    """A mirror image: number `velocity` of the last axis, if any, changes sign."""
    part = part.copy()
    if velocity is not None:
        part[..., velocity] *= -1.0
    return part


def _turned_slopes(part, axis):
    """A mirror image of slopes (..., 2, 3): those along the axis change sign, and so do those of its velocity."""
    part = part.copy()
    part[..., axis, :] *= -1.0
    part[..., 1 + axis] *= -1.0
    return part
