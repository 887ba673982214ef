"""How a depth-averaged run will go, before it runs: blocks that slide down from the release without pushing each other.

A block is a point on the ground with the thickness of the release where it starts,

    dw/dt = -s (g + w.B w) / (1 + s^2) - friction,   s = grad b,   B = grad grad b

(`depth.gather` without pressure), in steps as long as those of the run. The fastest block gives the length of a step,
and when the blocks have stopped, the run ends. Pressure, which spreads a flow, is left out.
"""

import math
from dataclasses import dataclass, replace

import numpy as np
from scipy import ndimage

from snowmpm.depth.plan_grid import MARGIN
from snowmpm.ground.states import stresses
from snowmpm.quantities.motion import MOVING_SPEED

BLOCKS = 100
"""Blocks at most, spread evenly over the columns."""
DEEPER = 4.0
"""Depth that a flow reaches where it is squeezed or stops, over that of its release, for the waves that limit its
steps: 4.5 in the library's valley."""
STRIDE = 3
"""Steps of the columns in one of the blocks, which no wave limits."""
MOST_STEPS = 20000
"""Steps after which the rest of the run is taken to go on as it is."""


@dataclass(frozen=True)
class Course:
    """What blocks did. steps: of the run; rests: time when the last of them stops [s], inf if none does; last: step of
    a run that rests [s]; speed: largest
    [m/s]; bend: largest depth over radius of curvature of the ground along a path [-]; slope: steepest angle on the way
    [degrees]; lift: largest share of the weight that the ground's curvature takes off [-]: above 1, snow leaves the
    ground; way: length in plan of the longest way of a block [m]."""

    steps: int
    rests: float
    last: float
    speed: float
    bend: float
    slope: float
    lift: float
    way: float = 0.0

    def later(self, delay, end_time):
        """The same, of which a part begins `delay` [s] later: until then the flow is taken to need as many steps as
        after that."""
        if delay <= 0.0 or self.rests == math.inf:
            return self
        rests = self.rests + delay
        return replace(self, rests=rests if rests < end_time else math.inf,
                       steps=math.ceil(self.steps * min(rests, end_time) / max(self.rests, 1e-9)))


class Blocks:
    """Blocks on a bed. state: plan, velocity (n, 2) [m], [m/s], depth, density (n,); friction: (law class, numbers
    (rows, parameters), number of the row of each node (nx, ny), below 0 for holes); load: None, or
    (`column_load.ColumnLoad.share`, index of the material (n,)): the ground bears less of them."""

    def __init__(self, grid, bed, gravity, friction, state, centrifugal=True, load=None):
        plan, velocity, depth, density = state
        self._grid, self._g, self._centrifugal = grid, gravity, float(centrifugal)
        self._law, self._numbers, self._rows = friction
        inner = slice(MARGIN, -MARGIN)
        self._slopes = np.stack([part[inner, inner] for part in np.gradient(bed.heights, grid.dx)])
        self._heights = np.asarray(bed.heights, float)[inner, inner]
        self.plan, self.velocity = np.array(plan, float), np.array(velocity, float)
        self.depth, self.density = np.asarray(depth, float), np.asarray(density, float)
        self._share, self.material = load and load[0], load[1] if load else np.zeros(len(self.plan), int)
        self.time = self.bend = self.slope = self.lift = self.way = 0.0
        self._ways = np.zeros(len(self.plan))
        along = (self.velocity * self.slopes(self.plan)).sum(axis=1)
        self._energy = 0.5 * ((self.velocity**2).sum(axis=1) + along**2) + gravity * self._height()

    def _at(self, plan):
        return ((plan - self._grid.lower) / self._grid.dx - 0.5).T

    def slopes(self, plan):
        """grad b (n, 2) at places in plan."""
        at = self._at(plan)
        return np.stack([ndimage.map_coordinates(part, at, order=1, mode="nearest") for part in self._slopes], axis=1)

    def step(self, dt):
        """Advance by dt [s]; blocks that leave the ground's plan are gone."""
        w, s = self.velocity, self.slopes(self.plan)
        ahead = 0.5 * self._grid.dx * w / np.maximum(np.linalg.norm(w, axis=1), 1e-30)[:, None]
        change = self.slopes(self.plan + ahead) - self.slopes(self.plan - ahead)
        turn = np.linalg.norm(w, axis=1) * (change * w).sum(axis=1) / self._grid.dx
        metric = 1.0 + (s**2).sum(axis=1)
        cosine = 1.0 / np.sqrt(metric)
        before = np.sqrt((w**2).sum(axis=1) + (w * s).sum(axis=1) ** 2)
        new = w - dt * s * ((self._g + turn) / metric)[:, None]
        speed = np.sqrt((new**2).sum(axis=1) + (new * s).sum(axis=1) ** 2)
        normal = np.maximum(0.0, cosine * (self._g + self._centrifugal * turn))
        dry, rate = self._resistance(normal, before)
        kept = np.maximum(0.0, speed - dt * dry) / (1.0 + dt * rate) / np.maximum(speed, 1e-30)
        self._note(turn, before, cosine)
        self.velocity = new * kept[:, None]
        move = 0.5 * dt * (w + self.velocity)
        self.plan += move
        self._ways += np.linalg.norm(move, axis=1)
        self.way = max(self.way, float(self._ways.max(initial=0.0)))
        self.time += dt
        # Steps longer than the ground's bends would gain energy from them: none is faster than its fall allows
        most = np.sqrt(2.0 * np.maximum(self._energy - self._g * self._height(), 0.0))
        self.velocity *= np.minimum(1.0, most / np.maximum(speed * kept, 1e-30))[:, None]
        fastest = float(np.minimum(speed * kept, most).max(initial=0.0))
        self._leave()
        return fastest

    def _height(self):
        """Of the ground under the blocks (n,) [m]; it has no holes there."""
        return ndimage.map_coordinates(self._heights, self._at(self.plan), order=1, mode="nearest")

    def _resistance(self, normal, speed):
        """Dry part [m/s2] and rate [1/s] of the friction per mass."""
        cells = self._cells()
        load = self.density * self.depth
        share = self._share(self.material, self.depth, self.time) if self._share else 1.0
        states = np.stack([self.density, share * load * normal, speed, self.depth], axis=1)
        result = stresses(self._law, self._numbers[self._rows[cells]], states)
        return result[:, 0] / load, result[:, 1] / load

    def _cells(self):
        cells = np.floor((self.plan - self._grid.lower) / self._grid.dx).astype(int)
        return tuple(np.clip(cells, 0, self._grid.shape - 1).T)

    def _leave(self):
        at = (self.plan - self._grid.lower) / self._grid.dx
        stay = ((at >= 0.0) & (at < self._grid.shape)).all(axis=1) & (self._rows[self._cells()] >= 0)
        if not stay.all():
            for name in ("plan", "velocity", "depth", "density", "material", "_energy", "_ways"):
                setattr(self, name, vars(self)[name][stay])

    def _note(self, turn, speed, cosine):
        """Curvature along the way: turn = v^2 / (R cos)."""
        if not len(speed):
            return
        moving = speed > MOVING_SPEED
        radius = np.where(moving, np.abs(turn) * cosine / np.maximum(speed, MOVING_SPEED) ** 2, 0.0)
        self.bend = max(self.bend, float((radius * self.depth).max(initial=0.0)))
        self.slope = max(self.slope, math.degrees(math.acos(float(cosine.min(initial=1.0)))))
        self.lift = max(self.lift, float((-turn / self._g).max(initial=0.0)))


def run_blocks(blocks, longest, end_time, interval):
    """`Course` of blocks until they rest. longest(speed) -> dt [s] of a run whose fastest column has that speed;
    interval [s]: between frames, each of which ends a step."""
    time, steps, most, rests = 0.0, 0, 0.0, math.inf
    speed = float(np.linalg.norm(blocks.velocity, axis=1).max(initial=0.0))
    moved = speed > 0.0
    while time < end_time and len(blocks.plan) and steps < MOST_STEPS:
        dt = interval / math.ceil(interval / longest(speed) - 1e-9)
        speed = blocks.step(STRIDE * dt)
        time, steps, most = time + STRIDE * dt, steps + STRIDE, max(most, speed)
        moved |= speed > MOVING_SPEED
        if speed <= MOVING_SPEED and (moved or time > 0.1 * end_time):
            rests = time
            break
    if 0.0 < time < end_time and rests == math.inf and len(blocks.plan):
        steps = math.ceil(steps * end_time / time)
    last = interval / math.ceil(interval / longest(0.0) - 1e-9)
    return Course(max(steps, 1), rests if len(blocks.plan) else time, last, most, blocks.bend, blocks.slope,
                  blocks.lift, blocks.way)
