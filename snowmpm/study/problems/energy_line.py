"""A thin strip runs down a slope, round an arc and out on the flat, and stops where Coulomb friction says (M19).

For a strip that is short against the radius R of the arc, the mean of its particles follows, with s the way and theta
the dip under it,

    d(v^2 / 2) / ds = g sin theta - mu (g cos theta + v^2 / R)

On straight parts that is the energy line, z + v^2 / 2g + x tan delta = const, x the mean way of the particles in plan.
The strip is elastic and soft, so that nothing is lost but by friction; it hangs together, so its ends do not matter.
"""

import numpy as np

from snowmpm.errors import SimulationError
from snowmpm.materials import Elastic
from snowmpm.particles.population import Population
from snowmpm.study.problems.schemes import lattice

G, MU, DIP, RADIUS, SLOPE = 9.81, 0.2, np.deg2rad(20.0), 10.0, 10.0
LONG, THICK = 1.5, 0.2
SOFT = Elastic(density=300.0, youngs_modulus=2e5, poisson_ratio=0.0)
AT_REST, LATEST = 0.02, 20.0
"""Speed [m/s] below which it has stopped, and when it must have [s]."""


class HockeyStick:
    """Terrain: a slope towards +x, an arc, and the flat z = 0. The arc touches the flat at x = 0."""

    def __init__(self):
        self.centre = np.array([0.0, RADIUS])
        self.start = self.centre + RADIUS * np.array([-np.sin(DIP), -np.cos(DIP)])  # of the arc
        self.along = np.array([np.cos(DIP), -np.sin(DIP)])
        self.up = np.array([np.sin(DIP), np.cos(DIP)])

    def query(self, points):
        on_slope = (points - self.start) @ self.along < 0.0
        on_flat = points[:, 0] > 0.0
        inwards = self.centre - points
        reach = np.linalg.norm(inwards, axis=1)
        distance = np.where(on_slope, (points - self.start) @ self.up, np.where(on_flat, points[:, 1], RADIUS - reach))
        arc = inwards / np.maximum(reach, 1e-12)[:, None]
        normal = np.where(on_slope[:, None], self.up, np.where(on_flat[:, None], [0.0, 1.0], arc))
        return distance, normal

    def height(self, x):
        """z [m] of the ground at x."""
        bend = RADIUS - np.sqrt(RADIUS**2 - np.clip(x, self.start[0], 0.0) ** 2)
        return bend + np.tan(DIP) * np.maximum(self.start[0] - x, 0.0)

    def way(self, points):
        """Along the surface, 0 where the arc begins [m]."""
        on_slope = (points - self.start) @ self.along
        angle = DIP - np.arctan2(-points[:, 0], RADIUS - points[:, 1])
        return np.where(on_slope < 0.0, on_slope,
                        np.where(points[:, 0] > 0.0, RADIUS * DIP + points[:, 0], RADIUS * angle))


def exact_way(start, height):
    """Way at which a mass point stops that starts at rest; it slides `height` above the surface."""
    radius = RADIUS - height

    def rate(s, energy):
        on_arc = 0.0 < s < RADIUS * DIP
        theta = DIP if s <= 0.0 else max(0.0, DIP - s / RADIUS)
        pressing = G * np.cos(theta) + (2.0 * energy[0] / radius if on_arc else 0.0)
        return [G * np.sin(theta) - MU * pressing]

    def stopped(s, energy):
        return energy[0]

    from scipy.integrate import solve_ivp  # slow to import

    stopped.terminal, stopped.direction = True, -1
    return solve_ivp(rate, (start, start + 100.0), [1e-9], events=stopped, max_step=0.02, rtol=1e-8).t[-1]


def strip(scheme, cells, per_axis=2):
    """Solver of the strip at rest on the slope, and the ground; cells: in its thickness."""
    ground, dx = HockeyStick(), THICK / cells
    local, volumes = lattice([-SLOPE, 0.0], [-SLOPE + LONG, THICK], dx, per_axis)
    x = ground.start + local[:, :1] * ground.along + local[:, 1:] * ground.up
    return scheme.solver(Population(x, volumes, 0), [SOFT], dx=dx, origin=np.array([-20.0, -2.0]),
                         lower=np.array([-20.0, -2.0]), upper=np.array([30.0, 12.0]), gravity=np.array([0.0, -G]),
                         terrain=ground, terrain_contact="separate", terrain_friction=MU), ground


def stops(solver):
    """Take 50 steps at a time, yielding in between, until nothing moves; raises SimulationError when it never does."""
    while solver.time < 1.0 or np.linalg.norm(solver.particles.column("velocity"), axis=1).max() > AT_REST:
        for _ in range(50):
            solver.step(solver.stable_dt()[0])
        if solver.time > LATEST:
            raise SimulationError(f"the strip does not stop in {LATEST:g} s")
        yield


def run_out_error(scheme, cells, per_axis=2):
    """Way of the strip over the exact one, less 1."""
    solver, ground = strip(scheme, cells, per_axis)
    begin = ground.way(solver.particles.positions()).mean()
    for _ in stops(solver):
        pass
    run = ground.way(solver.particles.positions()).mean() - begin
    return run / (exact_way(begin, 0.5 * THICK) - begin) - 1.0
