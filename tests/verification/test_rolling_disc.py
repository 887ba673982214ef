"""A disc and a sphere on an incline of 30 deg (M13): they roll with a = 2/3 or 5/7 g sin θ where mu > tan θ / 3 or
2/7 tan θ, else slip with a = g (sin θ - mu cos θ) while the rim gains 2 or 5/2 mu g cos θ.

R = 0.5 m, E = 5e6 Pa, nu = 0.3, rho = 1000 kg/m3, on a plane oblique to the grid. The particles lie in shells, for a
cut lattice has bumps of a quarter of a cell, over which it hops. It starts pressed against the plane by its own weight
(put there without stress, it bounces) and from above: what comes down to the plane is stopped `lines.GAP` above it, and
a disc that starts lower has to climb so far as it begins to roll, with its weight ahead of its centre.
"""

from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest

from snowmpm.materials import Elastic
from snowmpm.mpm.contact.lines import GAP
from snowmpm.mpm.solver import MpmSolver
from snowmpm.particles.population import Population
from snowmpm.study.problems.rigid_walls import Plane
from snowmpm.study.problems.schemes import APIC

G, RADIUS, SLOPE, TILT = 9.81, 0.5, np.pi / 6.0, 0.3
LAW = Elastic(density=1000.0, youngs_modulus=5e6, poisson_ratio=0.3)


def on_circle(n, _):
    angle = 2.0 * np.pi * np.arange(n) / n
    return np.stack([np.cos(angle), np.sin(angle)], axis=1)


def on_sphere(n, turned):
    """n points at equal areas, along a spiral."""
    height, angle = 1.0 - (2.0 * np.arange(n) + 1.0) / n, turned + np.pi * (3.0 - np.sqrt(5.0)) * np.arange(n)
    across = np.sqrt(1.0 - height**2)
    return np.stack([across * np.cos(angle), across * np.sin(angle), height], axis=1)


def ball(dim, dx):
    """Positions and volumes of a disc or a sphere in shells of half a cell around the origin."""
    step, positions, volumes = 0.5 * dx, [], []
    edges = np.arange(round(RADIUS / step) + 1) * step
    for inner, outer in pairwise(edges):
        volume = np.pi * (outer**2 - inner**2) if dim == 2 else 4.0 / 3.0 * np.pi * (outer**3 - inner**3)
        n = round(volume / step**dim)
        positions.append(0.5 * (inner + outer) * (on_circle if dim == 2 else on_sphere)(n, outer / step))
        volumes.append(np.full(n, volume / n))
    return np.concatenate(positions), np.concatenate(volumes)


def plane_of(dim):
    plane = Plane(TILT, (0.013, 0.021))
    if dim == 3:  # turned about the vertical too
        turn = np.array([[np.cos(0.4), np.sin(0.4), 0.0], [0.0, 0.0, 1.0]])
        plane.point, plane.along, plane.normal = (v @ turn for v in (plane.point, plane.along, plane.normal))
    return plane


def roll(dim, mu, dx, duration=1.0):
    """-> acceleration of the centre down the slope [m/s2], speed of the rim over that of the centre at the end."""
    plane, (x, volumes) = plane_of(dim), ball(dim, dx)
    positions = plane.point + (RADIUS + GAP * dx) * plane.normal + x
    lower, upper = positions.min(axis=0) - 4.0, positions.max(axis=0) + 4.0
    solver = MpmSolver(Population(positions, volumes, 0), [LAW], dx=dx, precision="f64", lower=lower, upper=upper,
                       origin=dx * np.floor(lower / dx), gravity=-G * np.cos(SLOPE) * plane.normal, terrain=plane,
                       terrain_contact="separate", terrain_friction=mu, **APIC.options)
    while solver.time < 0.4:
        dt = solver.stable_dt()[0]
        solver.damping_factor = 1.0 - 0.05 * dt * LAW.wave_speed() / dx
        solver.step(dt)
    solver.damping_factor = 1.0
    solver.restart_clock()
    solver.set_loads([(plane.point, 1e3, -G * np.sin(SLOPE) * plane.along)])
    rows = []
    while solver.time < duration:
        for _ in range(20):
            solver.step(solver.stable_dt()[0])
        particles = solver.particles
        place, velocity, mass = particles.positions(), particles.column("velocity"), particles.masses()
        centre, speed = (mass @ v / mass.sum() for v in (place, velocity))
        arm, around = (SimpleNamespace(t=v @ plane.along, n=v @ plane.normal)
                       for v in (place - centre, velocity - speed))
        spin = mass @ (arm.t * around.n - arm.n * around.t) / (mass @ (arm.t**2 + arm.n**2))
        rows.append((solver.time, -speed @ plane.along, spin * RADIUS))
    time, speed, rim = np.array(rows).T
    fitted, last = time > 0.1 * duration, time > 0.8 * duration
    return np.polyfit(time[fitted], speed[fitted], 1)[0], rim[last].mean() / speed[last].mean()


def test_a_disc_slips_on_a_smooth_slope():
    exact = G * (np.sin(SLOPE) - 0.1 * np.cos(SLOPE))
    acceleration, rim = roll(2, 0.1, 0.05)
    assert acceleration == pytest.approx(exact, rel=0.005)
    assert rim == pytest.approx(2.0 * 0.1 * G * np.cos(SLOPE) / exact, abs=0.02)


@pytest.mark.parametrize(("dx", "tolerance"), [(0.05, 0.02), pytest.param(0.025, 0.01, marks=pytest.mark.slow)])
def test_a_disc_rolls_on_a_rough_slope(dx, tolerance):
    acceleration, rim = roll(2, 0.5, dx)
    assert acceleration == pytest.approx(2.0 / 3.0 * G * np.sin(SLOPE), rel=tolerance)
    assert rim == pytest.approx(1.0, abs=2.5 * tolerance)


@pytest.mark.slow
def test_a_sphere_rolls_on_a_rough_slope():
    acceleration, rim = roll(3, 0.5, 0.05)
    assert acceleration == pytest.approx(5.0 / 7.0 * G * np.sin(SLOPE), rel=0.05)
    assert rim == pytest.approx(1.0, abs=0.05)
