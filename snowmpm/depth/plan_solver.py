"""What the two schemes of the depth-averaged method share: ground, friction, obstacles, forecast."""

from typing import Any

import numpy as np

from snowmpm.compiler import runtime
from snowmpm.depth.bed import Bed
from snowmpm.depth.blocks import BLOCKS, Blocks, run_blocks
from snowmpm.depth.gather import LEAST_DEPTH
from snowmpm.depth.loads import Gauges
from snowmpm.depth.plan_grid import PlanGrid
from snowmpm.errors import InputError
from snowmpm.ground.friction import GroundFriction
from snowmpm.particles.coordinates import Frame
from snowmpm.stepping.component import Adapters
from snowmpm.stepping.contract import Forecasts, Method, PushesObstacles
from snowmpm.stepping.setting import Setting

WALLS = ("slip", "symmetric")
"""Sides that send snow back."""


class PlanSolver(Method, PushesObstacles, Forecasts):
    """Snow that flows in plan over a ground. grid, bed, adapters, gravity; law: class of its friction."""

    particles: Any
    _gauges: Any

    def __init__(self, options, friction, setting: Setting):
        """friction: `ground.friction.GroundFriction`, or a law whose parameters are all numbers; setting: its obstacles
        are those whose loads are wanted. Raises InputError for a gravity that does not point down."""
        self.precision, self.options, self.adapters = setting.precision, options, Adapters(setting.adapters)
        self.gravity = np.asarray(setting.gravity, float)
        if np.abs(self.gravity[:2]).max() > 0.0 or self.gravity[2] > 0.0:
            raise InputError.at("gravity", self.gravity.tolist(), 'must point down for solver.method = "depth"')
        self.frame = Frame(3, setting.precision, setting.lower, setting.dx, setting.lower, setting.upper)
        first, last = aligned(setting.lower, setting.upper, setting.dx, setting.terrain)
        self._sides = setting.walls
        self.grid = PlanGrid(first, last, setting.dx, [side[0] == "periodic" for side in self._sides[:2]])
        self.bed = Bed(setting.terrain, self.grid, [[name in WALLS for name in side] for side in self._sides[:2]])
        self._law, self._numbers = self.on_ground(friction)
        for changed in self.adapters.friction:
            self._law, self._numbers = changed(self._law, self._numbers, self.grid)
        self._place = np.arange(self.grid.n_nodes) if len(self._numbers) > 1 else np.zeros(self.grid.n_nodes, int)
        self._place[self.grid.nodes()[self.bed.holes]] = -1
        self._gauges = None

    def _gauge(self, obstacles, mass, population):
        if obstacles:
            mean = mass / max(float(population.volumes.sum()), 1e-300)
            self._gauges = Gauges(obstacles, self.grid, self.bed, -float(self.gravity[2]), mean)

    @property
    def sides(self):
        """Names of what stands at the ends of both axes (2, 2)."""
        return [list(side) for side in self._sides[:2]]

    @property
    def real(self):
        """Taichi type of its numbers."""
        return runtime.DTYPES[self.precision][0]

    def on_ground(self, friction):
        """Class of a law, and its numbers: a row, or one a node. friction: `ground.friction.GroundFriction`, or a law
        whose parameters are all numbers."""
        law, g = friction.law if isinstance(friction, GroundFriction) else friction, -float(self.gravity[2])
        if not (isinstance(friction, GroundFriction) and friction.varies):
            return type(law), np.array([law.parameters(g)], float)
        x, y = np.moveaxis(self.grid.places(), -1, 0)
        numbers = friction.on_nodes(x.ravel(), y.ravel(), on_terrain=~self.bed.holes.ravel(), gravity=g)
        return type(law), self.grid.flat(numbers.T.reshape(*self.grid.shape, -1))

    def _course(self, density, step, last_start, end_time, interval, load=None):
        """`Course` of a run from now, by blocks that slide down from where the snow is. density (materials,); step:
        length of one [s] by the speed; last_start [s]; load: a share of the snow that bears, by material."""
        store, grid = self.particles, self.grid
        if store.count == 0 or self.gravity[2] == 0.0:
            return None
        snapshot = store.snapshot()
        chosen = np.unique(np.linspace(0, store.count - 1, min(store.count, BLOCKS)).astype(int))
        position, w = snapshot.positions()[chosen, :2], snapshot.column("velocity")[chosen, :2]
        material = snapshot.labels[chosen, 0]
        state = position, w, np.maximum(LEAST_DEPTH, snapshot.thickness()[chosen]), density[material]
        blocks = Blocks(grid, self.bed, -float(self.gravity[2]),
                        (self._law, self._numbers.astype(float), self._place[grid.nodes()]), state,
                        self.options.centrifugal, load and (load, material))
        return run_blocks(blocks, step, end_time, interval).later(last_start, end_time)

    @property
    def obstacle_totals(self):
        """`PushesObstacles.obstacle_totals` (`depth.loads`)."""
        return self._gauges.totals if self._gauges else np.zeros((0, 7))


def aligned(lower, upper, dx, terrain):
    """Plan corners of the grid: its cells fall together with those of an elevation raster of the same size."""
    lower, upper = np.asarray(lower, float)[:2], np.asarray(upper, float)[:2]
    lattice = getattr(terrain, "lattice", None)
    if lattice is None or abs(lattice[1] - dx) > 1e-6 * dx:
        return lower, upper
    first = np.floor((lower - lattice[0]) / dx + 1e-6)
    return lattice[0] + first * dx, upper
