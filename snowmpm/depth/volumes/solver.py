"""Depth-averaged flow by finite volumes: `kernels` over the cells of a plan grid."""

import math
from dataclasses import asdict

import numpy as np

from snowmpm.compiler import runtime
from snowmpm.compiler.parallel import runs_serially
from snowmpm.depth.bed import Bed
from snowmpm.depth.plan_grid import MARGIN, PlanGrid
from snowmpm.depth.solver import WALLS, aligned
from snowmpm.depth.volumes import kernels as steps
from snowmpm.depth.volumes.cells import FlowCells
from snowmpm.errors import InputError, SimulationError
from snowmpm.ground.friction import GroundFriction
from snowmpm.particles.coordinates import Frame
from snowmpm.stepping.component import Adapters
from snowmpm.stepping.contract import Forecasts, Method, StepLimits, Totals, Workload
from snowmpm.stepping.setting import Setting
from snowmpm.stepping.time_step import Extremes

USUAL_CFL, CRITICAL_CFL = 0.8, 1.0
"""Sum over both axes of what waves and snow cross of a cell in a step: usual, and at most."""

AWAKE = 3
"""Steps without a look for snow in new tiles, fewer than these have cells."""

CELL_STEP = 200e-9
"""Time of a step [s] a cell on one thread."""


class VolumeSolver(Method, Forecasts):
    """Snow of one material that flows over a ground, in cells."""

    def __init__(self, population, laws, options, *, friction, **setting):
        """Arguments as of `depth.solver.DepthSolver`. Raises InputError for what this scheme does not compute."""
        given = Setting(**setting)
        _refuse(population, options, given)
        self.precision, self.options, self.adapters = given.precision, options, Adapters(given.adapters)
        self.gravity = np.asarray(given.gravity, float)
        if np.abs(self.gravity[:2]).max() > 0.0 or self.gravity[2] > 0.0:
            raise InputError.at("gravity", self.gravity.tolist(), 'must point down for solver.method = "depth"')
        self.frame = Frame(3, given.precision, given.lower, given.dx, given.lower, given.upper)
        first, last = aligned(given.lower, given.upper, given.dx, given.terrain)
        self._sides = given.walls
        self.grid = PlanGrid(first, last, given.dx, [side[0] == "periodic" for side in self._sides[:2]])
        self.bed = Bed(given.terrain, self.grid, [[name in WALLS for name in side] for side in self._sides[:2]])
        real = runtime.DTYPES[given.precision][1]
        ground, heights = _derivatives(self.bed.heights, given.dx)
        self.particles = FlowCells(population, laws, self.grid, ground.astype(real), heights, given.precision)
        self.cfl = given.cfl or USUAL_CFL
        self._tables(friction, real)
        self.extremes = Extremes(float(np.linalg.norm(population.velocities, axis=1).max(initial=0.0)))
        self.time, self.steps, self.unconverged = 0.0, 0, 0
        self.restart_clock()
        self._look()

    def _tables(self, friction, real):
        nx, ny = self.particles.state_array.shape[:2]
        n, rows = nx * ny, -(-ny // steps.TILE)
        self._live = np.zeros(-(-nx // steps.TILE) * rows, np.int32)
        self._tiles = steps.Tiles(self._live, len(self._live), rows, nx, ny)
        self._report = np.zeros((len(self._live), steps.REPORT))
        flat = self.particles.state_array.reshape(n, 3)
        empty = [np.zeros((n, *shape), real) for shape in ((3,), (steps.SLOPES,), (2, steps.FLUX))]
        self._cells = steps.Cells(flat, np.ones(n, np.int32), np.ones(n, real), *empty,
                                  self.particles.ground.reshape(n, steps.GROUND))
        law, g = friction.law if isinstance(friction, GroundFriction) else friction, -float(self.gravity[2])
        self._law, place = type(law), np.zeros((nx, ny), np.int32)
        if isinstance(friction, GroundFriction) and friction.varies:
            x, y = np.moveaxis(self.grid.places(), -1, 0)
            numbers = friction.on_nodes(x.ravel(), y.ravel(), on_terrain=~self.bed.holes.ravel(), gravity=g).T
            place = np.pad(np.arange(self.grid.shape.prod()).reshape(self.grid.shape), MARGIN, mode="edge")
        else:
            numbers = np.array([law.parameters(g)], float)
        self._friction = steps.Friction(np.ascontiguousarray(place.ravel(), np.int32), np.ascontiguousarray(numbers),
                                        self.particles.density)
        outside = np.zeros((nx, ny), bool)
        FlowCells.inner(outside)[:] = self.bed.holes
        for axis in (0, 1):
            for end, part in ((0, slice(0, MARGIN)), (1, slice(-MARGIN, None))):
                if self._sides[axis][end] not in (*WALLS, "periodic"):
                    np.moveaxis(outside, axis, 0)[part] = True
        self._outside = np.flatnonzero(outside)
        self._mass, self._awake = self.particles.mass, 0
        self._serial = runs_serially(CELL_STEP * max(1, int((flat[:, 0] > 0.0).sum())))

    # ---- the step ---------------------------------------------------------------------------------------------

    def _wake(self):
        """Tiles that hold snow, or have it next to them, are live; what others held of a step before is cleared. Snow
        gets no further than a cell in a step: a look at every fourth of them is soon enough."""
        if self._awake > 0:
            self._awake -= 1
            return
        self._awake = AWAKE
        shape = len(self._live) // self._tiles.rows, self._tiles.rows
        side = steps.TILE
        padded = np.zeros((shape[0] * side, shape[1] * side), bool)
        state = self.particles.state_array
        padded[: state.shape[0], : state.shape[1]] = state[..., 0] > 0.0
        held = padded.reshape(shape[0], side, shape[1], side).any(axis=(1, 3))
        wide = np.pad(held, 1)
        near = sum(wide[i : i + shape[0], j : j + shape[1]].astype(np.int32) for i in range(3) for j in range(3)) > 0
        for tile in np.flatnonzero(self._live & ~near.ravel()):
            i, j = divmod(int(tile), shape[1])
            part = slice(i * side, (i + 1) * side), slice(j * side, (j + 1) * side)
            for array in (self._cells.ahead, self._cells.slopes, self._cells.flux):
                array.reshape(*state.shape[:2], *array.shape[1:])[part] = 0.0
        self._live[:] = near.ravel()

    def step(self, dt):
        """Advance by dt [s]."""
        self._beyond()  # first, so that snow at one end of a periodic axis wakes the other
        self._wake()
        real, g = runtime.DTYPES[self.precision][0], -float(self.gravity[2])
        step = steps.Step(dt, self.grid.dx, g, float(self.options.centrifugal))
        self._report[:] = 0.0
        with runtime.precision(self.precision):
            kernels = steps.kernels(real, self._law, self._serial)
            kernels.rub(self._cells, self._friction, self._tiles, step, self._report)
            self._beyond()
            kernels.predict(self._cells, self._tiles, step)
            self._mirror_ahead()
            kernels.cross(self._cells, self._tiles, step)
            kernels.drain(self._cells, self._tiles, step)
            self._fill(self._cells.share.reshape(*self.particles.state_array.shape[:2], 1), (None, None))
            kernels.update(self._cells, self._friction, self._tiles, step, self._report)
        self.time += dt
        self.steps += 1
        self._lose()
        self.particles.changed()
        self._read()
        self.weight_impulse += dt * self._mass * self.gravity

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
        rows = state.reshape(-1, 3)
        lost = self._outside[rows[self._outside, 0] > 0.0]
        if len(lost):
            mass = rows[lost, 0].astype(float) * grid.dx**2 * self.particles.density
            plan = rows[lost, 1:].astype(float)
            ground = self.particles.ground.reshape(len(rows), -1)[lost, :2]
            velocity = np.column_stack([plan, (plan * ground).sum(axis=1)])
            removed = self.particles.removed
            removed["count"] += len(lost)
            removed["mass"] += float(mass.sum())
            removed["momentum"] = removed["momentum"] + mass @ velocity
            removed["energy"] += float(mass @ (0.5 * (velocity**2).sum(axis=1)
                                               - self.gravity[2] * self.particles.heights.ravel()[lost]))
            rows[lost] = 0.0
            self._mass = self.particles.mass

    def _read(self):
        speed2 = float(self._report[:, steps.SPEED2].max())
        work = float(self._report[:, steps.WORK].sum())
        if not np.isfinite(speed2 + work):
            self._fail()
        self.extremes = Extremes(speed=math.sqrt(speed2))
        self.contact_work += work * self.particles.density * self.grid.dx**2
        self._rate = float(self._report[:, steps.RATE].max())

    def _fail(self):
        bad = np.argwhere(~np.isfinite(FlowCells.inner(self.particles.state_array)).all(axis=2))
        where = f"cell ({bad[0][0]}, {bad[0][1]})" if len(bad) else "a cell"
        raise SimulationError(f"{where} has no finite depth or velocity, at t = {self.time:.6g} s, step {self.steps}:\n"
                              "lower solver.cfl or check the friction of the ground")

    def _look(self):
        """The largest rate at which cells are crossed, of the snow as it is."""
        state, ground = self.particles.state_array.astype(float), self.particles.ground.astype(float)
        wave = np.sqrt(-self.gravity[2] * state[..., 0] * ground[..., 5] ** 4)
        wide = wave * (np.sqrt(1.0 + ground[..., 0] ** 2) + np.sqrt(1.0 + ground[..., 1] ** 2))
        rates = np.abs(state[..., 1:]).sum(axis=-1) + wide
        self._rate = float(rates[state[..., 0] > 0.0].max(initial=0.0)) / self.grid.dx

    # ---- its length -------------------------------------------------------------------------------------------

    def _longest(self, share):
        """dt and cause: snow that speeds up with g crosses at most `share` of a cell."""
        g, way = -float(self.gravity[2]), share * self.grid.dx
        speed = max(self._rate * self.grid.dx, 1e-30)
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

    @property
    def limits(self):
        """`StepLimits`."""
        return StepLimits(self.cfl, CRITICAL_CFL, "depth-averaged flow by finite volumes", USUAL_CFL)

    def restart_clock(self):
        """Time zero is now: totals start again."""
        self.time, self.steps, self.contact_work = 0.0, 0, 0.0
        self.weight_impulse = np.zeros(3)
        self._start = self._momentum() + self.particles.removed["momentum"]

    # ---- reading ----------------------------------------------------------------------------------------------

    def _momentum(self):
        return self.particles.masses() @ self.particles.column("velocity") if self.particles.count else np.zeros(3)

    @property
    def totals(self):
        """`Totals` as they are now: all that changes the momentum, but for the weight, comes from the ground."""
        given = self._momentum() + self.particles.removed["momentum"] - self._start - self.weight_impulse
        return Totals(given, self.weight_impulse.copy(), np.zeros(3), 0.0, self.contact_work)

    @property
    def workload(self):
        """`Workload` of a step."""
        return Workload(self.particles.n_blocks)

    @property
    def memory(self):
        """Bytes of everything but the cells with snow."""
        return sum(array.nbytes for array in (*self._cells, self._friction.place, self._friction.numbers))

    # ---- checkpoint -------------------------------------------------------------------------------------------

    def state(self):
        """All that a bitwise continuation needs, by name."""
        return {"cells": self.particles.state(), "frame": self.frame.bounds, "extremes": asdict(self.extremes),
                "rate": self._rate, "time": self.time, "steps": self.steps, "contact_work": self.contact_work,
                "weight_impulse": self.weight_impulse.copy(), "start": self._start.copy()}

    def restore(self, state):
        """Take over the `state()` of a solver of the same scene. Raises InputError when it does not fit."""
        self.frame.check(state["frame"])
        self.particles.restore(state["cells"])
        self._mass, self._awake = self.particles.mass, 0
        self.extremes, self._rate = Extremes(**state["extremes"]), state["rate"]
        self.time, self.steps, self.contact_work = state["time"], state["steps"], state["contact_work"]
        self.weight_impulse, self._start = np.array(state["weight_impulse"]), np.array(state["start"])


OF_COLUMNS = ("damping", "mixing", "rim")
"""Options that act on columns alone."""


def _refuse(population, options, given):
    scheme, usual = 'solver.depth.scheme = "volumes"', type(options)()
    for name in OF_COLUMNS:
        if options[name] != usual[name]:
            raise InputError.at(f"solver.depth.{name}", options[name], f"acts on columns, and goes without {scheme}")
    if len(np.unique(population.material)) > 1:
        raise InputError(f"{scheme}: takes snow of one material; columns take several")
    if (population.starts > 0.0).any():
        raise InputError(f"{scheme}: takes snow that is let go at the start; columns wait for their start_time")
    if given.obstacles:
        raise InputError(f"{scheme}: knows no obstacles; columns do")
    if given.adapters:
        raise InputError(f"{scheme}: goes without {', '.join(one.name for one in given.adapters)}; columns have it")


def _derivatives(heights, dx):
    """Slope, curvature (xx, yy, xy) and cosine (nx, ny, 6) of the spline of the ground at its nodes, and its height
    there, from its coefficients (nx, ny): the same ground as under columns."""
    def mean(values, axis):
        wide = np.pad(values, [(1, 1) if k == axis else (0, 0) for k in range(2)], mode="reflect", reflect_type="odd")
        parts = [np.take(wide, range(k, k + values.shape[axis]), axis) for k in range(3)]
        return 0.125 * (parts[0] + parts[2]) + 0.75 * parts[1]

    def change(values, axis, order):
        wide = np.pad(values, [(1, 1) if k == axis else (0, 0) for k in range(2)], mode="reflect", reflect_type="odd")
        parts = [np.take(wide, range(k, k + values.shape[axis]), axis) for k in range(3)]
        return 0.5 * (parts[2] - parts[0]) / dx if order == 1 else (parts[0] - 2.0 * parts[1] + parts[2]) / dx**2

    sx, sy = mean(change(heights, 0, 1), 1), mean(change(heights, 1, 1), 0)
    parts = [sx, sy, mean(change(heights, 0, 2), 1), mean(change(heights, 1, 2), 0),
             change(change(heights, 0, 1), 1, 1), 1.0 / np.sqrt(1.0 + sx**2 + sy**2)]
    return np.ascontiguousarray(np.stack(parts, axis=-1)), mean(mean(heights, 0), 1)


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
