"""Frictional sheets against the theory of shallow flow (M20), for a flow that Coulomb's law brakes at its bed.

With pressure K rho g_z (h - z) along the flow, h the depth, delta the friction angle of the bed,

    du/dt = g sin zeta - g_z tan delta - K g_z dh/dx,    g_z = g cos zeta

The grains need internal friction, or what the bed takes would not reach the surface. A Drucker-Prager law without
dilation that shears steadily has K = 1 and tau / sigma = sin phi (M15): with sin phi = tan delta the whole depth is
braked as by the bed, and where the flow stretches K stays at this smaller one of its two values,
K = 2 (1 - sqrt(1 - cos^2 phi (1 + tan^2 delta))) / cos^2 phi - 1 = 1.

Dam break of depth h0: h = ((2 c - x / t + m0 t / 2) / 3)^2 / g_z,
u = 2/3 (c + x / t + m0 t), m0 = g sin zeta - g_z tan delta, c = sqrt(g_z h0).
Parabolic cap h = H (1 - x^2 / L^2): stays one, its centre at m0 t^2 / 2, L'' = 2 g_z H0 L0 / L^2 (Savage and Hutter
1989, doi:10.1017/S0022112089000340). Its half-length is sqrt(5) standard deviations, which no lone grain moves.
"""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from snowmpm.materials import DruckerPrager
from snowmpm.mpm.solver import MpmSolver
from snowmpm.population import Population
from snowmpm.study.problems.particle_states import ParticleStates
from snowmpm.study.problems.rigid_walls import Plane
from snowmpm.study.problems.schemes import APIC, lattice

G = 9.81


def granular(bed, youngs_modulus):
    """The law whose steady shear is braked as by a bed of friction angle `bed` [rad]."""
    return DruckerPrager(density=1000.0, youngs_modulus=youngs_modulus, poisson_ratio=0.3, cone="plane_strain",
                         friction_angle=float(np.degrees(np.arcsin(np.tan(bed)))))


def sheet(law, positions, volumes, depth, slope, bed, dx, reach):
    """Solver of a sheet on the plane z = 0.3 dx in the pressure of its weight; depth (n,): of the snow above."""
    offset = np.array([0.0, 0.3 * dx])
    g_z = G * np.cos(slope)
    strain = -law.density * g_z * depth / (3.0 * law.bulk_modulus)
    isotropic = np.array([1.0, 1.0, 1.0, 0.0])
    population = Population(positions + offset, volumes, 0, elastic=np.expm1(2.0 * strain)[:, None] * isotropic,
                            stress=-(law.density * g_z * depth)[:, None] * isotropic)
    lower = np.array([positions[:, 0].min() - 10.0 * dx, -2.0 * dx])
    upper = np.array([reach, 3.0 * positions[:, 1].max()])
    solver = MpmSolver(population, [law], dx=dx, precision="f32", origin=lower, lower=lower, upper=upper,
                       gravity=np.array([G * np.sin(slope), -g_z]), terrain=Plane(0.0, offset),
                       terrain_contact="separate", terrain_friction=np.tan(bed), **APIC.options)
    ParticleStates(solver).set(volume_ratio=np.exp(3.0 * strain))
    return solver


def run_to(solver, time):
    while solver.time < time:
        solver.step(min(solver.stable_dt()[0], time - solver.time + 1e-9))


def profile(solver, ends):
    """Depth [m] and depth-averaged velocity along x [m/s] between plan positions `ends`."""
    x, v = solver.particles.positions()[:, 0], solver.particles.column("velocity")[:, 0]
    volume = solver.particles.column("volume")[:, 0] * solver.particles.column("volume_ratio")[:, 0]
    inside = np.histogram(x, ends, weights=volume)[0]
    flux = np.histogram(x, ends, weights=volume * v)[0]
    return inside / np.diff(ends), flux / np.maximum(inside, 1e-30)


def dam_break(time, dx):
    """Solver `time` [s] after a dam of 1 m broke, slope and friction angle of the bed [rad]."""
    slope, bed = np.radians(22.0), np.radians(21.0)
    positions, volumes = lattice([-60.0, 0.0], [0.0, 1.0], dx)
    solver = sheet(granular(bed, 1e6), positions, volumes, 1.0 - positions[:, 1], slope, bed, dx, 90.0)
    run_to(solver, time)
    return solver, slope, bed


@pytest.mark.slow
@pytest.mark.xfail(strict=True, reason="at the dam after 5 s the speed is 11 % short of the theory's")
def test_dam_break_early():
    """At the dam after five seconds: 0.514576 m, 2.621898 m/s (as tabulated)."""
    solver, _, _ = dam_break(5.0, 0.1)
    h, u = profile(solver, np.array([-1.0, 1.0]))
    assert h[0] == pytest.approx(0.514576, rel=0.1) and u[0] == pytest.approx(2.621898, rel=0.1)


@pytest.mark.slow
def test_dam_break():
    """Ten seconds after a dam of 1 m broke: by then the upright front that it began with, which is not shallow, is a
    seventieth of the flow."""
    time = 10.0
    solver, slope, bed = dam_break(time, 0.2)
    g_z = G * np.cos(slope)
    m0, c = G * np.sin(slope) - g_z * np.tan(bed), np.sqrt(g_z)
    ends = np.arange(-21.0, 66.0, 2.0)
    middle = 0.5 * (ends[1:] + ends[:-1])
    h, u = profile(solver, ends)
    exact_h = (2.0 * c - middle / time + 0.5 * m0 * time) ** 2 / (9.0 * g_z)
    exact_u = 2.0 / 3.0 * (c + middle / time + m0 * time)
    at_dam = 10
    assert middle[at_dam] == 0.0
    assert h[at_dam] == pytest.approx(exact_h[at_dam], rel=0.1) and u[at_dam] == pytest.approx(exact_u[at_dam], rel=0.1)
    assert np.abs(h - exact_h).max() < 0.1  # of the depth behind the dam, everywhere
    assert np.abs(u - exact_u)[h > 0.1].max() < 0.1 * exact_u[h > 0.1].max()
    # Where the depth falls below a tenth: thinner, it is less than half a cell
    front = np.interp(-0.1, -h[at_dam:], middle[at_dam:])
    assert front == pytest.approx(time * (2.0 * c + 0.5 * m0 * time - 3.0 * np.sqrt(0.1 * g_z)), rel=0.1)


@pytest.fixture(scope="module")
def cap():
    """Place, speed, depth and stretch of the cap by its time [s], each (found, exact)."""
    slope, bed, dx, half, height = np.radians(35.0), np.radians(25.0), 0.5, 80.0, 4.0
    positions, volumes = lattice([-half, 0.0], [half, height], dx)
    surface = height * (1.0 - (positions[:, 0] / half) ** 2)
    inside = positions[:, 1] < surface
    positions, volumes, depth = positions[inside], volumes[inside], (surface - positions[:, 1])[inside]
    solver = sheet(granular(bed, 3e6), positions, volumes, depth, slope, bed, dx, 260.0)
    g_z = G * np.cos(slope)
    m0 = G * np.sin(slope) - g_z * np.tan(bed)
    spread = positions[:, 0].std()
    solution = solve_ivp(lambda t, y: [y[1], 2.0 * g_z * height / (half * y[0]) ** 2], (0.0, 10.0), [1.0, 0.0],
                         rtol=1e-8, dense_output=True)
    found = {}
    for time in (5.0, 10.0):
        run_to(solver, time)
        x, stretch = solver.particles.positions()[:, 0], solution.sol(time)[0]
        centre, way = x.mean(), 0.5 * m0 * time**2
        found[time] = {
            "centre": (centre, way), "speed": (solver.particles.column("velocity")[:, 0].mean(), m0 * time),
            "front": (x.std() / spread * half + centre, stretch * half + way),
            "depth": (profile(solver, centre + np.array([-8.0, 8.0]))[0][0], height / stretch),
            "gain": (x.std() / spread - 1.0, stretch - 1.0)}
    return found


@pytest.mark.slow
@pytest.mark.parametrize("quantity", ["centre", "speed", "front", "depth", pytest.param("gain", marks=pytest.mark.xfail(
    strict=True, reason="the gain in length, a tenth at 5 s, is a quarter short of the theory's; as with K = 0.77"))])
def test_parabolic_cap(cap, quantity):
    for values in cap.values():
        found, exact = values[quantity]
        assert found == pytest.approx(exact, rel=0.1)
