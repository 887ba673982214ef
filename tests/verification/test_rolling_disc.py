"""A disc on an incline of 30 deg (M13): it rolls with a = 2/3 g sin θ where mu > tan θ / 3, else it slips with
a = g (sin θ - mu cos θ).

R = 0.5 m, E = 5e6 Pa, nu = 0.3, rho = 1000 kg/m3, rough or smooth plane that cuts the grid at 17 deg. Slip is exact to
a thousandth. Its way down is right within 2 % with ten cells to the radius; it turns too little, though.
"""

import functools

import numpy as np
import pytest

from snowmpm.materials import Elastic
from snowmpm.mpm.solver import MpmSolver
from snowmpm.population import Population
from tests.verification.rigid_walls import Plane
from tests.verification.schemes import APIC, lattice

G, RADIUS, SLOPE, TILT = 9.81, 0.5, np.pi / 6.0, 0.3
LAW = Elastic(density=1000.0, youngs_modulus=5e6, poisson_ratio=0.3)


def roll(scheme, mu, dx, duration=1.0):
    """-> acceleration of the centre down the slope [m/s2], speed of the rim over that of the centre at the end."""
    plane = Plane(TILT, (0.013, 0.021))
    x, _ = lattice([-RADIUS, -RADIUS], [RADIUS, RADIUS], dx)
    x = x[(x**2).sum(axis=1) < RADIUS**2]
    positions = plane.point + RADIUS * plane.normal + x
    lower, upper = positions.min(axis=0) - 4.0, positions.max(axis=0) + 4.0
    solver = MpmSolver(Population(positions, np.full(len(x), np.pi * RADIUS**2 / len(x)), 0), [LAW], dx=dx,
                       precision="f64", origin=dx * np.floor(lower / dx), lower=lower, upper=upper, terrain=plane,
                       gravity=-G * (np.sin(SLOPE) * plane.along + np.cos(SLOPE) * plane.normal),
                       terrain_contact="separate", terrain_friction=mu, **scheme.options)
    rows = []
    while solver.time < duration:
        for _ in range(20):
            solver.step(solver.stable_dt()[0])
        place, velocity = solver.particles.positions(), solver.particles.column("velocity")
        arm, around = place - place.mean(axis=0), velocity - velocity.mean(axis=0)
        spin = (arm[:, 0] * around[:, 1] - arm[:, 1] * around[:, 0]).mean() / (arm**2).sum(axis=1).mean()
        rows.append((solver.time, -velocity.mean(axis=0) @ plane.along, spin))
    time, speed, spin = np.array(rows).T
    fitted = time > 0.1 * duration
    return np.polyfit(time[fitted], speed[fitted], 1)[0], spin[-1] * RADIUS / speed[-1]


def test_a_disc_slips_on_a_smooth_slope():
    acceleration, rim = roll(APIC, 0.1, 0.05)
    assert acceleration == pytest.approx(G * (np.sin(SLOPE) - 0.1 * np.cos(SLOPE)), rel=0.005)
    assert 0.0 < rim < 0.5


@pytest.mark.parametrize("dx", [0.05, 0.025])
def test_a_disc_rolls_on_a_rough_slope(dx):
    assert rolling(dx)[0] == pytest.approx(2.0 / 3.0 * G * np.sin(SLOPE), rel=0.02)


@pytest.mark.xfail(strict=True, reason="the disc turns 10 % less than it rolls with twenty cells to the radius, 20 %"
                                       " with ten: the contact hops, and slips while it does")
def test_its_rim_keeps_up():
    assert rolling(0.025)[1] == pytest.approx(1.0, abs=0.05)


@functools.cache
def rolling(dx):
    return roll(APIC, 0.5, dx)
