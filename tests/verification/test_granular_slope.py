"""Slopes: a granular slab that slides off over its own grains (M15), and the weight at which a snow cover yields (M14).

M15, `granular_slab`: 20 cells. Periodic along the slope; on ground that is turned against the grid it is 8 H long, and
its foot, which nothing holds, pulls on it: it goes as the same slab on ground along the grid.

M14: at the foot of an elastic slab of weight S = rho g H per area, K0 = nu / (1 - nu) and c, s = cos θ, sin θ,
p = (c + 2 K0 c) S / 3, q = S sqrt((c - K0 c)^2 + 3 s^2): it yields where y(p, q) = 0. The lowest particles lie a
quarter of a cell higher. Gravity grows over 100 H / c_p with damped nodes, which lags by 1 %.
"""

import numpy as np
import pytest
from scipy.optimize import brentq

from snowmpm.materials import CohesiveCamClay
from snowmpm.mpm.solver import MpmSolver
from snowmpm.particles.population import Population
from snowmpm.study.problems.granular_slab import (
    STEEP,
    G,
    acceleration,
    exact_acceleration,
    gained,
    granular,
    pressed,
    slab,
)
from snowmpm.study.problems.particle_states import ParticleStates
from snowmpm.study.problems.rigid_walls import Plane
from snowmpm.study.problems.schemes import APIC, FLIP, lattice


def turned_slab(law, scheme, length, angle, **state):
    """-> solver of a slab 0.4 m deep on rough ground that rises by `angle` against the grid, and that ground."""
    dx = 0.02
    ground = Plane(angle, (0.37 * dx, 0.61 * dx))
    x, volumes = lattice([0.0, 0.0], [length, 0.4], dx)
    positions = ground.point + x[:, :1] * ground.along + x[:, 1:] * ground.normal
    lower, upper = positions.min(axis=0) - 1.0, positions.max(axis=0) + 1.0
    return MpmSolver(Population(positions, volumes, 0, **state), [law], dx=dx, precision="f64", lower=lower,
                     upper=upper, origin=dx * np.floor(lower / dx), terrain=ground, terrain_contact="stick",
                     gravity=-G * (np.sin(STEEP) * ground.along + np.cos(STEEP) * ground.normal),
                     **scheme.options), ground


def acceleration_in_the_middle(angle):
    """Of the surface of a long slab on ground that rises by `angle` against the grid [m/s2]."""
    law, length = granular(np.arcsin(0.5867 / np.sqrt(3.0))), 3.2
    x = lattice([0.0, 0.0], [length, 0.4], 0.02)[0]
    state, volume_ratio = pressed(law, x[:, 1], 0.4, STEEP)
    solver, ground = turned_slab(law, APIC, length, angle, **state)
    middle = (x[:, 1] > 0.36) & (np.abs(x[:, 0] - 0.5 * length) < 0.2)
    return gained(solver, volume_ratio, middle, -ground.along)


@pytest.mark.slow
def test_slab_on_ground_turned_by_thirty_degrees():
    assert acceleration_in_the_middle(np.pi / 6) == pytest.approx(acceleration_in_the_middle(0.0), rel=0.005)


@pytest.mark.parametrize("sine", [0.5867 / np.sqrt(3.0), 0.5])
@pytest.mark.parametrize(("scheme", "offset"), [(APIC, 0.0), (APIC, 1 / 3), (FLIP, 0.0)])
def test_slab_on_rough_ground(sine, scheme, offset):
    found = acceleration(np.arcsin(sine), scheme, offset=offset)
    assert found == pytest.approx(exact_acceleration(sine), rel=0.01)


SNOWS = {
    "warm": CohesiveCamClay(density=250.0, youngs_modulus=3e6, poisson_ratio=0.3, critical_slope=1.5, cohesion=0.3,
                            hardening=1.0, p0=30e3),
    "plug": CohesiveCamClay(density=250.0, youngs_modulus=3e6, poisson_ratio=0.3, critical_slope=0.5, cohesion=1.0,
                            hardening=0.1, p0=12e3),
}
WEIGHTS = {  # S [Pa] at 0, 30, 35 and 45 degrees
    "warm": (34019.93, 23076.35, 21055.27, 17753.80), "plug": (5785.85, 3431.91, 3126.65, 2673.22),
}


def yield_weight(law, slope):
    c, s, k0 = np.cos(slope), np.sin(slope), law.poisson_ratio / (1.0 - law.poisson_ratio)
    p, q = (c + 2.0 * k0 * c) / 3.0, np.sqrt((c - k0 * c) ** 2 + 3.0 * s**2)
    M, beta, p0 = law.critical_slope, law.cohesion, law.p0
    return brentq(lambda S: (S * q) ** 2 * (1.0 + 2.0 * beta) + M**2 * (S * p + beta * p0) * (S * p - p0), 1.0, 1e6)


def first_yield(law, scheme, slope, expected):
    """Weight over the lowest particles when the first of the slab yields [Pa]; gravity grows to 1.2 times expected."""
    depth, cells, c = 1.0, 32, law.wave_speed()
    solver, full = slab(law, scheme, depth, cells, slope, 0.0), 1.2 * expected / (law.density * depth)
    states, down = ParticleStates(solver), np.array([np.sin(slope), -np.cos(slope)])
    while solver.n_plastic == 0 and solver.time < 100.0 * depth / c:
        dt = solver.stable_dt()[0]
        gravity = full * solver.time * c / (100.0 * depth)
        solver.damping_factor = 1.0 - 0.02 * dt * c / solver.dx
        states.add(velocity=np.broadcast_to(dt * gravity * down, (len(states.mass), 2)))
        solver.step(dt)
    return law.density * gravity * (depth - 0.25 * depth / cells)


@pytest.mark.parametrize(("name", "degrees"), [("warm", 0), ("warm", 35), ("plug", 35), ("plug", 45)])
def test_weight_at_first_yield(name, degrees):
    law, slope = SNOWS[name], np.radians(degrees)
    exact = yield_weight(law, slope)
    assert exact == pytest.approx(WEIGHTS[name][[0, 30, 35, 45].index(degrees)], abs=0.005)
    assert first_yield(law, APIC, slope, exact) == pytest.approx(exact, rel=0.03)
