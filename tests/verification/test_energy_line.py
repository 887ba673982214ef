"""A thin strip runs down a slope, round an arc and out on the flat, and stops where Coulomb friction says (M19).

For a strip that is short against the radius R of the arc, the mean of its particles follows, with s the way and theta
the dip under it,

    d(v^2 / 2) / ds = g sin theta - mu (g cos theta + v^2 / R)

On straight parts that is the energy line, z + v^2 / 2g + x tan delta = const, x the mean way of the particles in plan.
The strip is elastic and soft, so that nothing is lost but by friction; it hangs together, so its ends do not matter.
"""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from snowmpm.materials import Elastic
from snowmpm.mpm.solver import MpmSolver
from snowmpm.population import Population
from snowmpm.study.problems.schemes import lattice

G, MU, DIP, RADIUS, SLOPE = 9.81, 0.2, np.deg2rad(20.0), 10.0, 10.0
LONG, THICK, DX = 1.5, 0.2, 0.1
SOFT = Elastic(density=300.0, youngs_modulus=2e5, poisson_ratio=0.0)


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

    stopped.terminal, stopped.direction = True, -1
    return solve_ivp(rate, (start, start + 100.0), [1e-9], events=stopped, max_step=0.02, rtol=1e-8).t[-1]


@pytest.mark.parametrize("transfer", ["apic", "aflip"])
def test_strip_stops_where_friction_says(transfer):
    ground = HockeyStick()
    local, volumes = lattice([-SLOPE, 0.0], [-SLOPE + LONG, THICK], DX)
    x = ground.start + local[:, :1] * ground.along + local[:, 1:] * ground.up
    solver = MpmSolver(Population(x, volumes, 0), [SOFT], dx=DX, precision="f64", origin=[-20.0, -2.0],
                       lower=[-20.0, -2.0], upper=[30.0, 12.0], gravity=[0.0, -G], terrain=ground,
                       terrain_contact="separate", terrain_friction=MU, transfer=transfer)
    begin = ground.way(x).mean()
    checked = False
    while solver.time < 1.0 or np.linalg.norm(solver.particles.column("velocity"), axis=1).max() > 0.02:
        for _ in range(50):
            solver.step(solver.stable_dt()[0])
        assert solver.time < 20.0, "it does not stop"
        now, v = solver.particles.positions(), solver.particles.column("velocity")
        if not checked and ground.way(now).max() > -2.0:
            # Still on the slope: the energy line falls by mu a metre in plan
            drop = (x - now)[:, 1].mean() - 0.5 * (v**2).sum(axis=1).mean() / G
            assert drop / (now - x)[:, 0].mean() == pytest.approx(MU, rel=0.02)
            checked = True
    assert checked
    run = ground.way(solver.particles.positions()).mean() - begin
    assert run == pytest.approx(exact_way(begin, 0.5 * THICK) - begin, rel=0.02)
