"""Dams that break at x = 0, in one line of cells: columns in a channel, and the theory of shallow water.

With g_z = g cos(zeta), m0 = g_z (tan zeta - tan delta), c = sqrt(g_z h0) on a plane at zeta with friction delta, x
along it and h normal to it:

    h = (2 c - x/t + m0 t/2)^2 / (9 g_z)  from  m0 t/2 - c  to  m0 t/2 + 2 c = x/t      (zeta = delta = 0: Ritter)

On a wet bed (Stoker), the fan ends at a plateau, and that at a shock.
"""

from dataclasses import dataclass

import numpy as np

from tests.support.depth_flows import OPEN, USUAL, WALL, G, Ground, coulomb, flow, graded, profile, run_to, slope

LINES = 3
"""Cells across the channel, the fewest that a grid has; one column a cell across."""


@dataclass(frozen=True)
class DryDam:
    """Snow 1 m deep on a plane, both angles in degrees."""

    slope: float = 0.0
    friction: float = 0.0

    @property
    def g_z(self):
        return G * np.cos(np.radians(self.slope))

    @property
    def drive(self):
        """m0 [m/s2]"""
        return self.g_z * (np.tan(np.radians(self.slope)) - np.tan(np.radians(self.friction)))

    def place(self, depth, time):
        """x at which the flow is so deep; depth 0: the front."""
        c = np.sqrt(self.g_z)
        return time * (2.0 * c + 0.5 * self.drive * time - 3.0 * np.sqrt(self.g_z * depth))

    def depth(self, x, time):
        fan = np.clip(x, self.place(1.0, time), self.place(0.0, time))
        return ((self.place(0.0, time) - fan) / time) ** 2 / (9.0 * self.g_z)

    def broken(self, dx, time, rear, *, options=USUAL, per_cell=4):
        """Depth profile x, h along the plane [m] after `time` [s] and solver; dx: cells in plan; rear: length of the
        snow [m].

        The front stretches without bound, and equal columns part there: 16 of a cell give fronts that are 9 % too far,
        since one column alone is as deep as the threshold. So columns near the dam are smaller, in proportion to the
        distance from it, to 1/64: half a cell apart at most where the volume ahead is c0 t h^1.5.
        """
        cosine = np.cos(np.radians(self.slope))
        x, widths = graded(-rear * cosine, 0.0, dx / per_cell, 1.1 * time)
        top = 1.05 * self.place(0.0, time) * cosine + 10.0 * dx
        ground = Ground(slope(self.slope), (-rear * cosine, 0.0), (top, LINES * dx), coulomb(self.friction),
                        (["slip", "open"] if self.slope == 0.0 else OPEN, WALL))
        solver = run_to(channel(x, widths / cosine, ground, dx, options), time)
        x, depth = profile(solver)
        return x / cosine, depth * cosine, solver


@dataclass(frozen=True)
class WetDam:
    """1 m of snow beside 0.1 m, on the flat, without friction."""

    plateau: float = 0.396175
    speed: float = 2.321355
    shock: float = 3.105134
    ahead: float = 0.1

    @property
    def end_of_fan(self):
        """x/t"""
        return self.speed - np.sqrt(G * self.plateau)

    def depth(self, x, time):
        z, c = x / time, np.sqrt(G)
        fan = (2.0 * c - np.clip(z, -c, self.end_of_fan)) ** 2 / (9.0 * G)
        return np.where(z < self.end_of_fan, fan, np.where(z < self.shock, self.plateau, self.ahead))

    def broken(self, dx, time, *, options=USUAL, per_cell=4):
        """x, h [m] after `time` [s] and solver. Columns are as wide on both sides."""
        cells = round(14.0 / dx) * per_cell
        widths = np.full(cells, 14.0 / cells)
        x = -6.0 + (np.arange(cells) + 0.5) * widths
        ground = Ground(slope(0.0), (-6.0, 0.0), (8.0, LINES * dx), sides=(WALL, WALL))
        solver = channel(x, widths * np.where(x < 0.0, 1.0, self.ahead), ground, dx, options)
        return *profile(run_to(solver, time)), solver


def channel(x, areas, ground, dx, options):
    """Solver of columns at x (n,) that hold the volumes areas (n,) [m2] of a metre of width."""
    y = (np.arange(LINES) + 0.5) * dx
    plan = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
    return flow(plan, np.repeat(areas, LINES) * dx, ground, dx, options=options)
