"""Force of a depth-averaged flow on obstacles: of the flow as it would be without them, which does not feel them.

    F = (c_d / 2 rho v^2 + rho g d / 2) d b   along the flow,   d = min(depth, height)

the stagnation pressure with the coefficient c_d of the obstacle's shape, and the pressure of the snow's weight on its
upstream side, mean over the depth d that it bears on; b: width of the obstacle across the flow. Voellmy (1955), Ueber
die Zerstoerungskraft von Lawinen; Johannesson et al. (2009), The design of avalanche protection dams, EUR 23339, on
impact pressures: c_d about 2 for walls, 1 to 1.5 for masts. Depth (vertical) and velocity are those of the nodes of
the cells that its outline touches, means by volume; when the flow stops, the weight keeps its last direction.
"""

import numpy as np
import shapely

from snowmpm.compiler import ti
from snowmpm.compiler.arrays import int_array
from snowmpm.compiler.launch import taichi_kernel
from snowmpm.depth.plan_grid import MARGIN

SLOWEST = 0.1
"""Speed [m/s] below which the direction of the load stays."""


@taichi_kernel
def _pick(totals: ti.types.ndarray(), places: ti.types.ndarray(), picked: ti.types.ndarray()):
    ti.loop_config(serialize=True)
    for k in range(places.shape[0]):
        for m in ti.static(range(3)):
            picked[k, m] = totals[places[k]][m]


class Gauge:
    """An obstacle in plan. drag: c_d [-]; cells: of the plan grid that it touches (k, 2); top [m]."""

    def __init__(self, obstacle, grid):
        vertices = np.asarray(obstacle.shape.drawing()[0])
        self.drag = obstacle.drag
        self._outline = shapely.convex_hull(shapely.MultiPoint(vertices[:, :2]))
        self._corners = shapely.get_coordinates(self._outline)
        self.centre, self.top = np.asarray(obstacle.motion.start_centre, float), float(vertices[:, 2].max())
        low = np.floor((self._corners.min(axis=0) - grid.lower) / grid.dx).astype(int).clip(0, grid.shape - 1)
        high = np.floor((self._corners.max(axis=0) - grid.lower) / grid.dx).astype(int).clip(0, grid.shape - 1)
        i, j = (axis.ravel() for axis in np.meshgrid(*(np.arange(a, b + 1) for a, b in zip(low, high, strict=True)),
                                                     indexing="ij"))
        corner = grid.lower + grid.dx * np.column_stack([i, j])
        touched = shapely.intersects(self._outline, shapely.box(*corner.T, *(corner + grid.dx).T))
        self.nodes = grid.nodes()[i[touched], j[touched]]
        self.middle = np.array(self._outline.centroid.coords[0])
        self.direction = np.zeros(2)

    def width(self, direction):
        """Width [m] across a direction in plan (2,)."""
        return float(np.ptp(self._corners @ np.array([-direction[1], direction[0]])))


class Gauges:
    """totals (n, 7): impulse (3) [N s], moment (3) [N m s] about the middle of the shape and work 0 [J], of each."""

    def __init__(self, obstacles, grid, bed, g, density):
        """obstacles: `solids.Obstacle`s that stand still; g [m/s2]; density: mean of the snow [kg/m3]."""
        self._gauges = [Gauge(obstacle, grid) for obstacle in obstacles]
        self._g, self._dx, self._density, self.totals = g, grid.dx, density, np.zeros((len(self._gauges), 7))
        self._grounds = [_ground(gauge.middle, grid, bed) for gauge in self._gauges]
        self._ends = np.cumsum([len(gauge.nodes) for gauge in self._gauges])
        self.nodes = np.concatenate([gauge.nodes for gauge in self._gauges])
        """of the plan grid, whose snow they feel"""
        self._places, self._picked = int_array(self.nodes), np.zeros((self._ends[-1], 3))

    def feel_nodes(self, totals, unit, dt):
        """Add the load of a step. totals: Taichi (n_nodes,), of `depth.nodes`: volume, and volume times velocity in
        plan, over `unit` [m3]."""
        _pick(totals, self._places, self._picked)
        self.feel(self._picked * unit, dt)

    def feel(self, sums, dt):
        """Add the load of a step. sums (k, 3): volume [m3], and volume times velocity in plan, at `nodes`."""
        parts = np.split(sums, self._ends[:-1])
        for gauge, (ground, slope), sums, total in zip(self._gauges, self._grounds, parts, self.totals, strict=True):
            force, height = self._force(gauge, sums, gauge.top - ground, slope)
            arm = np.array([*gauge.middle, ground + 0.5 * height]) - gauge.centre
            total[:3] += dt * force
            total[3:6] += dt * np.cross(arm, force)

    def _force(self, gauge, sums, stands, slope):
        """Force (3,) [N], and depth [m] that it acts over."""
        volume, rho = sums[:, 0].sum(), self._density
        if volume <= 0.0 or stands <= 0.0:
            return np.zeros(3), 0.0
        velocity = sums[:, 1:].sum(axis=0) / volume
        depth = min(volume / (len(sums) * self._dx**2), stands)
        speed = float(np.hypot(np.linalg.norm(velocity), velocity @ slope))
        if speed > SLOWEST:
            gauge.direction = velocity / np.linalg.norm(velocity)
        if not gauge.direction.any():
            return np.zeros(3), depth
        pressure = 0.5 * gauge.drag * rho * speed**2 + 0.5 * rho * self._g * depth
        along = np.array([*gauge.direction, gauge.direction @ slope])
        return pressure * depth * gauge.width(gauge.direction) * along / np.linalg.norm(along), depth

    def state(self):
        """What changes, by name."""
        return {"totals": self.totals.copy(), "directions": np.array([gauge.direction for gauge in self._gauges])}

    def restore(self, state):
        """Take over a `state()`."""
        self.totals = np.array(state["totals"])
        for gauge, direction in zip(self._gauges, state["directions"], strict=True):
            gauge.direction = np.array(direction)


def _ground(place, grid, bed):
    """Height [m] and slope (2,) of the ground at a place in plan, at time zero."""
    cell, _ = grid.cells(place[None])
    i, j = (cell[0].clip(0, grid.shape - 1)) + MARGIN
    z = bed.heights
    return float(z[i, j]), 0.5 * np.array([z[i + 1, j] - z[i - 1, j], z[i, j + 1] - z[i, j - 1]]) / grid.dx
