"""Slopes: a granular slab that slides off over its own grains (M15), and the weight at which a snow cover yields (M14).

M15: without dilation, steady shear leaves s_xx = s_yy = 0, so that a Drucker-Prager slab on rough ground carries
tau / sigma_n = alpha / sqrt(3), which is sin(phi), not tan(phi), on the cone that meets Mohr-Coulomb in plane strain:

    a = g (sin θ - alpha / sqrt(3) cos θ),  whatever the thickness of the band that shears.

H = 0.4 m, 20 cells; E = 1e6 Pa, nu = 0.3, rho = 1500 kg/m3; it starts in the pressure rho g cos θ (H - y). Periodic
along the slope; on ground that is turned against the grid it is 8 H long, and its foot, which nothing holds, pulls on
it: it goes as the same slab on ground along the grid.

M14: at the foot of an elastic slab of weight S = rho g H per area, K0 = nu / (1 - nu) and c, s = cos θ, sin θ,
p = (c + 2 K0 c) S / 3, q = S sqrt((c - K0 c)^2 + 3 s^2): it yields where y(p, q) = 0. The lowest particles lie a
quarter of a cell higher. Gravity grows over 100 H / c_p with damped nodes, which lags by 1 %.
"""

import numpy as np
import pytest
from scipy.optimize import brentq

from snowmpm.materials import CohesiveCamClay, DruckerPrager
from snowmpm.mpm.solver import MpmSolver
from snowmpm.population import Population
from tests.verification.particle_states import ParticleStates
from tests.verification.rigid_walls import Plane
from tests.verification.schemes import APIC, FLIP, lattice

G, STEEP = 9.81, np.radians(35.0)


def slab(law, scheme, depth, cells, slope, gravity, offset=0.0, **state):
    """A slab on rough ground `offset` cells above a node, eight cells of it, periodic along the slope."""
    dx = depth / cells
    positions, volumes = lattice([0.0, 0.0], [8 * dx, depth], dx)
    base = np.array([0.0, offset * dx])
    return MpmSolver(Population(positions + base, volumes, 0, **state), [law], dx=dx, precision="f64",
                     origin=np.zeros(2), lower=base, upper=np.array([8 * dx, 2 * depth]),
                     gravity=gravity * np.array([np.sin(slope), -np.cos(slope)]),
                     sides=[["periodic", "periodic"], ["stick", "open"]], **scheme.options)


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


def pressed(law, height, depth, slope):
    """Stress and elastic state of particles in the pressure of what lies above them, and their volume ratio."""
    pressure = law.density * G * np.cos(slope) * (depth - height)
    strain = -pressure / (3.0 * law.bulk_modulus)
    isotropic = np.array([1.0, 1.0, 1.0, 0.0])
    return dict(elastic=np.expm1(2.0 * strain)[:, None] * isotropic,
                stress=-pressure[:, None] * isotropic), np.exp(3.0 * strain)


def granular(friction_angle):
    """A granular law; friction_angle [rad]."""
    return DruckerPrager(density=1500.0, youngs_modulus=1e6, poisson_ratio=0.3, cone="plane_strain",
                         friction_angle=float(np.degrees(friction_angle)))


def gained(solver, volume_ratio, chosen, down):
    """Acceleration of the chosen particles along `down` from 0.15 to 0.4 s [m/s2]."""
    states, rows = ParticleStates(solver), []
    states.set(volume_ratio=volume_ratio)
    while solver.time < 0.4:
        for _ in range(10):
            solver.step(solver.stable_dt()[0])
        rows.append((solver.time, (states.column("velocity")[chosen] @ down).mean()))
    time, speed = np.array(rows).T
    return np.polyfit(time[time > 0.15], speed[time > 0.15], 1)[0]


def acceleration(friction_angle, scheme, cells=20, offset=0.0, slope=STEEP, depth=0.4):
    """Of the upper tenth of a granular slab [m/s2]; friction_angle [rad]."""
    law = granular(friction_angle)
    height = lattice([0.0, 0.0], [8 * depth / cells, depth], depth / cells)[0][:, 1]
    state, volume_ratio = pressed(law, height, depth, slope)
    solver = slab(law, scheme, depth, cells, slope, G, offset, **state)
    return gained(solver, volume_ratio, height > 0.9 * depth, np.array([1.0, 0.0]))


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
    exact = G * (np.sin(STEEP) - sine * np.cos(STEEP))
    assert acceleration(np.arcsin(sine), scheme, offset=offset) == pytest.approx(exact, rel=0.01)


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
        solver.keep = 1.0 - 0.02 * dt * c / solver.dx
        states.add(velocity=np.broadcast_to(dt * gravity * down, (len(states.mass), 2)))
        solver.step(dt)
    return law.density * gravity * (depth - 0.25 * depth / cells)


@pytest.mark.parametrize(("name", "degrees"), [("warm", 0), ("warm", 35), ("plug", 35), ("plug", 45)])
def test_weight_at_first_yield(name, degrees):
    law, slope = SNOWS[name], np.radians(degrees)
    exact = yield_weight(law, slope)
    assert exact == pytest.approx(WEIGHTS[name][[0, 30, 35, 45].index(degrees)], abs=0.005)
    assert first_yield(law, APIC, slope, exact) == pytest.approx(exact, rel=0.03)
