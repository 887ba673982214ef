"""A cloud of the powder layer by itself over a plane, without a scene."""

import numpy as np

from snowmpm.compiler import runtime
from snowmpm.components.powder_layer.arrays import Below
from snowmpm.components.powder_layer.closures import AIR_DENSITY, ICE_DENSITY
from snowmpm.components.powder_layer.cloud import PowderCloud
from snowmpm.components.powder_layer.declare import PowderLayer
from snowmpm.depth.plan_grid import MARGIN, PlanGrid

G, CORE = 9.81, 200.0
EXCESS = ICE_DENSITY - AIR_DENSITY
OPEN, WALL, ROUND = ("open", "open"), ("slip", "slip"), ("periodic", "periodic")
ALONE = {"suspension": "none", "air_entrainment": "none", "core_drag": 0.0, "fall_speed": 0.0, "ground_drag": 0.0,
         "top_drag": 0.0, "front_drag": 0.0}
"""Nothing but weight and pressure."""


def cloud_over(cells, dx, *, slope=(0.0, 0.0), sides=(OPEN, WALL), g=G, holes=None, **options):
    """`PowderCloud` over a plane of (nx, ny) cells that falls by `slope` per metre along x and y, without flow."""
    runtime.start("cpu")
    grid = PlanGrid((0.0, 0.0), np.array(cells) * dx, dx, [side[0] == "periodic" for side in sides])
    shape = tuple(int(n) + 2 * MARGIN for n in grid.shape)
    ground = np.zeros((*shape, 6))
    ground[..., 0], ground[..., 1] = -slope[0], -slope[1]
    ground[..., 5] = 1.0 / np.sqrt(1.0 + slope[0] ** 2 + slope[1] ** 2)
    x, y = (np.arange(n) - MARGIN + 0.5 for n in shape)
    heights = -dx * (slope[0] * x[:, None] + slope[1] * y)
    below = Below(np.zeros((*shape, 3)), ground, heights, CORE)
    return PowderCloud(below, grid, sides, np.zeros(tuple(grid.shape), bool) if holes is None else holes, g,
                       PowderLayer(**{**ALONE, **options}))


def fill(cloud, V, c, u=0.0, v=0.0):
    """Cloud of volume V [m] over plan, share of ice c and velocity in plan in all cells (nx, ny), of one profile."""
    inner, numbers = cloud.inner, cloud.numbers
    inner[..., 0] = V
    inner[..., 1] = c * inner[..., 0]
    weight = AIR_DENSITY * inner[..., 0] + numbers.cu * EXCESS * inner[..., 1]
    inner[..., 2], inner[..., 3] = weight * u, weight * v
    cloud.restart()


def read(cloud):
    """V [m], c, u, v (nx, ny)."""
    V, ice, mx, my = np.moveaxis(cloud.inner, -1, 0)
    held = V > 1e-9
    weight = AIR_DENSITY * V + cloud.numbers.cu * EXCESS * ice
    shares = (ice, V), (mx, weight), (my, weight)
    return V, *(np.divide(one, by, out=np.zeros_like(V), where=held) for one, by in shares)


def run_to(cloud, end, dt):
    """Advance by steps of dt [s]."""
    for _ in range(round(end / dt)):
        cloud.advance(dt)
