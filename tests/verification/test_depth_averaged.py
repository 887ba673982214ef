"""Frictional sheets against the theory of shallow flow (M20), for a flow that Coulomb's law brakes at its bed.

With pressure K rho g_z (h - z) along the flow, h the depth, delta the friction angle of the bed,

    du/dt = g sin zeta - g_z tan delta - K g_z dh/dx,    g_z = g cos zeta

The grains need internal friction, or what the bed takes would not reach the surface. A Drucker-Prager law without
dilation that shears steadily has K = 1 and tau / sigma = sin phi (M15): with sin phi = tan delta the whole depth is
braked as by the bed, and where the flow stretches K stays at this smaller one of its two values,
K = 2 (1 - sqrt(1 - cos^2 phi (1 + tan^2 delta))) / cos^2 phi - 1 = 1.

Dam break of depth h0: h = ((2 c - x / t + m0 t / 2) / 3)^2 / g_z,
u = 2/3 (c + x / t + m0 t), m0 = g sin zeta - g_z tan delta, c = sqrt(g_z h0). It begins with an upright front that
falls at once, as no flow does whose pressure is that of its depth; all later depths and speeds come from there on
straight ways. On a bed of 21 degrees ours has made up for its first second after ten, within a tenth; by five it has
not, whatever the method, but a flow that begins two seconds after the theory's dam broke goes with the theory.
Parabolic cap h = H (1 - x^2 / L^2): stays one, its centre at m0 t^2 / 2, L'' = 2 g_z H0 L0 / L^2 (Savage and Hutter
1989, doi:10.1017/S0022112089000340). Its half-length is sqrt(5) standard deviations, which no lone grain moves.

The theory takes tan delta for small. It leaves out that friction carries weight: across the flow, with tau = tan delta
sigma, 0 = d sigma / dz + d tau / dx + rho g_z makes the pressure on the bed rho g_z h (1 - tan delta dh/dx), more where
the flow gets thinner. The bed then brakes the front more and the rear less, by tan^2 delta g_z dh/dx in du/dt, as if

    K -> K - tan^2 delta

however shallow the flow: 0.78 for 25 degrees, 0.98 for 8. So what stretches a flow is compared with the theory as it
stands where friction is weak, and with this where it is not.
"""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from snowmpm.materials import DruckerPrager
from snowmpm.particles.population import Population
from snowmpm.study.problems.particle_states import ParticleStates
from snowmpm.study.problems.rigid_walls import Plane
from snowmpm.study.problems.schemes import APIC, Scheme, lattice

G = 9.81
SINGLE = replace(APIC, precision="f32")
SPH = Scheme("none", precision="f32", method="sph")


def granular(bed, youngs_modulus):
    """The law whose steady shear is braked as by a bed of friction angle `bed` [rad]."""
    return DruckerPrager(density=1000.0, youngs_modulus=youngs_modulus, poisson_ratio=0.3, cone="plane_strain",
                         friction_angle=float(np.degrees(np.arcsin(np.tan(bed)))))


def sheet(law, positions, volumes, depth, slope, bed, dx, reach, velocities=None, scheme=SINGLE):
    """Solver of a sheet on the plane z = 0.3 dx in the pressure of its weight; depth (n,): of the snow above."""
    offset = np.array([0.0, 0.3 * dx])
    g_z = G * np.cos(slope)
    strain = -law.density * g_z * depth / (3.0 * law.bulk_modulus)
    isotropic = np.array([1.0, 1.0, 1.0, 0.0])
    population = Population(positions + offset, volumes, 0, velocities,
                            elastic=np.expm1(2.0 * strain)[:, None] * isotropic,
                            stress=-(law.density * g_z * depth)[:, None] * isotropic)
    lower = np.array([positions[:, 0].min() - 10.0 * dx, -4.0 * dx])
    upper = np.array([reach, 3.0 * positions[:, 1].max()])
    solver = scheme.solver(population, [law], dx=dx, origin=lower, lower=lower, upper=upper,
                           gravity=np.array([G * np.sin(slope), -g_z]), terrain=Plane(0.0, offset),
                           terrain_contact="separate", terrain_friction=np.tan(bed))
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


def theory(x, time, slope, bed):
    """Depth [m] and speed [m/s] at x, `time` [s] after a dam of 1 m broke at x = 0; slope and bed [rad]."""
    g_z = G * np.cos(slope)
    m0, c = G * np.sin(slope) - g_z * np.tan(bed), np.sqrt(g_z)
    rear, front = time * (0.5 * m0 * time - c), time * (0.5 * m0 * time + 2.0 * c)
    h = (2.0 * c - np.clip(x, rear, front) / time + 0.5 * m0 * time) ** 2 / (9.0 * g_z)
    return h, np.where(x < rear, m0 * time, 2.0 / 3.0 * (c + x / time + m0 * time))


def dam_break(time, dx, slope_angle=22.0, bed_angle=21.0, *, since=0.0, scheme=SINGLE):
    """Solver, slope and friction angle of the bed [rad], `time` [s] after a dam of 1 m broke.

    since: when the run begins [s], from the theory's depth and speed then; 0, from an upright front.
    """
    slope, bed = np.radians(slope_angle), np.radians(bed_angle)
    ahead = 0.0 if since == 0.0 else 90.0
    positions, volumes = lattice([-60.0, 0.0], [ahead, 1.0], dx, 1 if scheme.method == "sph" else 2)
    x, z = positions.T
    surface, velocities = np.ones(len(x)), np.zeros_like(positions)
    if since > 0.0:
        surface, velocities[:, 0] = theory(x, since, slope, bed)
        velocities[:, 1] = np.where(surface < 1.0, -2.0 / (3.0 * since) * z, 0.0)  # as deep as it stretches
    inside = z < surface
    solver = sheet(granular(bed, 1e6), positions[inside], volumes[inside], (surface - z)[inside], slope, bed, dx, 90.0,
                   velocities[inside], scheme)
    run_to(solver, time - since)
    return solver, slope, bed


def at_the_dam(time, *scene, **choices):
    """Depth and speed at the dam over those of the theory."""
    solver, slope, bed = dam_break(time, 0.1, *scene, **choices)
    h, u = profile(solver, np.array([-1.0, 1.0]))
    return np.array([h[0], u[0]]) / theory(0.0, time, slope, bed)


@pytest.mark.slow
@pytest.mark.parametrize(("slope_angle", "bed_angle", "since"), [
    (9.0, 8.0, 0.0), (22.0, 21.0, 2.0), pytest.param(22.0, 21.0, 0.0, marks=pytest.mark.xfail(
        strict=True, reason="13 % too deep, 11 % too slow; without a grid too, see the next test"))])
def test_dam_break_early(slope_angle, bed_angle, since):
    """At the dam after five seconds. On a bed of 8 degrees, from an upright front: seen 5 % too deep, 5 % too slow. On
    one of 21 degrees (0.514576 m, 2.621898 m/s) from the flow that the theory has after two: 3 % too shallow, 5 % too
    slow."""
    np.testing.assert_allclose(at_the_dam(5.0, slope_angle, bed_angle, since=since), 1.0, rtol=0.1)


@pytest.mark.slow
def test_upright_front_on_a_rough_bed():
    """What is left after five seconds of an upright front on 21 degrees, where grains with little but friction to move
    them begin 25 % too slow in the first second: found alike with and without a grid. So it is the theory that leaves
    it out. Seen: MPM 13 % too deep and 11 % too slow, SPH 14 and 7 %; with APIC and AFLIP, in float32 and float64
    alike."""
    grid, no_grid = at_the_dam(5.0), at_the_dam(5.0, scheme=SPH)
    np.testing.assert_allclose(grid, no_grid, rtol=0.06)
    for depth, speed in (grid, no_grid):
        assert 1.1 < depth < 1.2 and 0.85 < speed < 0.95


@pytest.mark.slow
@pytest.mark.parametrize(("time", "dx", "since"), [(10.0, 0.2, 0.0), (5.0, 0.1, 2.0)])
def test_dam_break(time, dx, since):
    """From the rear to the front: ten seconds after a dam of 1 m broke, by when the upright front that it began with is
    a seventieth of the flow, and after five where it began without."""
    solver, slope, bed = dam_break(time, dx, since=since)
    ends = np.arange(-21.0, 66.0, 2.0)
    middle = 0.5 * (ends[1:] + ends[:-1])
    h, u = profile(solver, ends)
    exact_h, exact_u = theory(middle, time, slope, bed)
    at_dam = 10
    assert middle[at_dam] == 0.0
    assert h[at_dam] == pytest.approx(exact_h[at_dam], rel=0.1) and u[at_dam] == pytest.approx(exact_u[at_dam], rel=0.1)
    assert np.abs(h - exact_h).max() < 0.1  # of the depth behind the dam, everywhere
    assert np.abs(u - exact_u)[h > 0.1].max() < 0.1 * exact_u[h > 0.1].max()
    # Where the depth falls below a tenth: thinner, it is less than half a cell
    front, exact = (np.interp(-0.1, -depth[at_dam:], middle[at_dam:]) for depth in (h, exact_h))
    assert front == pytest.approx(exact, rel=0.1)


HALF, HEIGHT = 80.0, 4.0
STRONG, WEAK = (35.0, 25.0), (12.0, 8.0)
"""Slope and friction angle of the bed [degrees]."""


def stretched(g_z, K, time):
    """Half-length of the cap over its first one."""
    return solve_ivp(lambda t, y: [y[1], 2.0 * K * g_z * HEIGHT / (HALF * y[0]) ** 2], (0.0, time), [1.0, 0.0],
                     rtol=1e-8).y[0, -1]


@pytest.fixture(scope="module", params=[STRONG, WEAK], ids=["strong", "weak"])
def cap(request):
    """Place, speed, depth and stretch of the cap by its time [s], each (found, exact); and its bed."""
    (slope, bed), dx = np.radians(request.param), 0.5
    positions, volumes = lattice([-HALF, 0.0], [HALF, HEIGHT], dx)
    surface = HEIGHT * (1.0 - (positions[:, 0] / HALF) ** 2)
    inside = positions[:, 1] < surface
    positions, volumes, depth = positions[inside], volumes[inside], (surface - positions[:, 1])[inside]
    solver = sheet(granular(bed, 3e6), positions, volumes, depth, slope, bed, dx, 260.0)
    g_z = G * np.cos(slope)
    m0 = G * np.sin(slope) - g_z * np.tan(bed)
    spread = positions[:, 0].std()
    K = 1.0 - np.tan(bed) ** 2 if request.param == STRONG else 1.0
    run_to(solver, 1.0)
    found = {"bed": pressure_on_the_bed(solver, g_z, np.tan(bed), dx)}
    for time in (5.0, 10.0):
        run_to(solver, time)
        x, stretch = solver.particles.positions()[:, 0], stretched(g_z, 1.0, time)
        centre, way = x.mean(), 0.5 * m0 * time**2
        found[time] = {
            "centre": (centre, way), "speed": (solver.particles.column("velocity")[:, 0].mean(), m0 * time),
            "front": (x.std() / spread * HALF + centre, stretch * HALF + way),
            "depth": (profile(solver, centre + np.array([-8.0, 8.0]))[0][0], HEIGHT / stretch),
            "gain": (x.std() / spread - 1.0, stretched(g_z, K, time) - 1.0)}
    return found


def pressure_on_the_bed(solver, g_z, friction, dx):
    """Normal stress in the lowest cell over that of the weight above it, and 1 - tan delta dh/dx, at six places."""
    p = solver.particles.positions()
    x, lowest = p[:, 0] - p[:, 0].mean(), p[:, 1] - 0.3 * dx < dx
    stress, pairs = solver.particles.column("stress")[:, 1], []
    for place in HALF * np.array([-0.6, -0.4, -0.2, 0.2, 0.4, 0.6]):
        near = np.abs(x - place) < 4.0
        h = profile(solver, p[:, 0].mean() + place + np.array([-4.0, 4.0]))[0][0]
        weight = 1000.0 * g_z * (h - 0.5 * dx)
        pairs.append((-stress[near & lowest].mean() / weight, 1.0 + friction * 2.0 * HEIGHT * place / HALF**2))
    return pairs


@pytest.mark.slow
@pytest.mark.parametrize("quantity", ["centre", "speed", "front", "depth", "gain"])
def test_parabolic_cap(cap, quantity):
    """The gain in length: of the theory as it stands 7 and 6 % short on a bed of 8 degrees; with K - tan^2 delta 3 %
    short and 1 % too long on one of 25, where the theory as it stands gives 23 and 19 % more."""
    for values in (cap[5.0], cap[10.0]):
        found, exact = values[quantity]
        assert found == pytest.approx(exact, rel=0.1)


@pytest.mark.slow
def test_friction_carries_weight(cap):
    """Before the cap has changed its shape. On 25 degrees 0.97 at the rear and 1.02 at the front, within 1 %."""
    found, expected = np.transpose(cap["bed"])
    np.testing.assert_allclose(found, expected, atol=0.02)
    assert found[-1] - found[0] == pytest.approx(expected[-1] - expected[0], abs=0.015)
