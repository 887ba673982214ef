"""An elastic block on an incline with Coulomb friction (M12): a = g (sin θ - mu cos θ), or rest.

Block 0.10 m x 0.05 m, dx = 0.01 m, E = 1e6 Pa, nu = 0.3, rho = 1000 kg/m3; mu = tan 15 deg. The slope is a plane that
cuts the grid at any angle (tilt), gravity turns with it. The block starts in the stress of its weight and its friction,
so that it does not bounce.
"""

from dataclasses import replace

import numpy as np
import pytest

from snowmpm.materials import Elastic
from snowmpm.mpm.solver import MpmSolver
from snowmpm.population import Population
from tests.verification.rigid_walls import Plane
from tests.verification.schemes import APIC, FLIP, lattice

G, LONG, HIGH, DX = 9.81, 0.1, 0.05, 0.01
MU = np.tan(np.radians(15.0))
LAW = Elastic(density=1000.0, youngs_modulus=1e6, poisson_ratio=0.3)


def sliding(slope, mu):
    """Acceleration down the slope [m/s2], 0 where friction holds."""
    return max(0.0, G * (np.sin(slope) - mu * np.cos(slope)))


def packed(tensor):
    return np.stack([tensor[:, 0, 0], tensor[:, 1, 1], tensor[:, 2, 2], tensor[:, 0, 1]], axis=1)


def slide(scheme, slope, tilt, duration, mu=MU):
    """-> time, way and speed down the slope of the block's centre. slope, tilt: of gravity's against the plane, of the
    plane against the grid [rad]."""
    plane, a = Plane(tilt, (0.0037, 0.0021)), sliding(slope, mu)
    x, volumes = lattice([0.0, 0.0], [LONG, HIGH], DX)
    positions = plane.point + x[:, :1] * plane.along + x[:, 1:] * plane.normal
    above = LAW.density * (HIGH - x[:, 1])
    stress = np.zeros((len(x), 3, 3))  # axes up the slope, out of it, and across
    stress[:, 1, 1] = -above * G * np.cos(slope)
    stress[:, 2, 2] = LAW.poisson_ratio * stress[:, 1, 1]
    stress[:, 0, 1] = stress[:, 1, 0] = -above * (G * np.sin(slope) - a)
    spherical = np.trace(stress, axis1=1, axis2=2)[:, None, None] * np.eye(3)
    strain = ((1.0 + LAW.poisson_ratio) * stress - LAW.poisson_ratio * spherical) / LAW.youngs_modulus
    axes = np.eye(3)
    axes[0, :2], axes[1, :2] = plane.along, plane.normal
    turned = [packed(np.einsum("ki,nkl,lj->nij", axes, tensor, axes)) for tensor in (stress, strain)]
    reach = 0.5 * a * duration**2 + 0.3
    lower, upper = positions.min(axis=0) - reach, positions.max(axis=0) + reach
    solver = MpmSolver(Population(positions, volumes, 0, stress=turned[0], elastic=2.0 * turned[1]), [LAW], dx=DX,
                       precision="f64", origin=DX * np.floor(lower / DX), lower=lower, upper=upper,
                       gravity=-G * (np.sin(slope) * plane.along + np.cos(slope) * plane.normal), terrain=plane,
                       terrain_contact="separate", terrain_friction=mu, **scheme.options)
    start, rows = positions.mean(axis=0), []
    while solver.time < duration:
        for _ in range(50):
            solver.step(solver.stable_dt()[0])
        rows.append((solver.time, -(solver.particles.positions().mean(axis=0) - start) @ plane.along,
                     -solver.particles.column("velocity").mean(axis=0) @ plane.along))
    return np.array(rows).T


def measured_acceleration(scheme, slope, tilt, duration, mu=MU):
    time, _, speed = slide(scheme, slope, tilt, duration, mu)
    return np.polyfit(time[time > 0.1 * duration], speed[time > 0.1 * duration], 1)[0]


@pytest.mark.parametrize(("scheme", "tilt"), [
    (APIC, 0), (APIC, 24), (APIC, 63), (FLIP, 24), (replace(APIC, kernel="cubic"), 24)], ids=str)
def test_acceleration(scheme, tilt):
    slope = np.radians(24.0)
    assert sliding(slope, MU) == pytest.approx(1.58875771, rel=1e-8)
    assert measured_acceleration(scheme, slope, np.radians(tilt), 0.4) == pytest.approx(1.58875771, rel=0.002)


@pytest.mark.slow
@pytest.mark.parametrize("tilt", range(0, 92, 7))
def test_acceleration_at_every_angle(tilt):
    assert measured_acceleration(APIC, np.radians(24.0), np.radians(tilt), 1.0) == pytest.approx(1.58875771, rel=0.002)


@pytest.mark.slow
def test_five_seconds():
    """20 m of slope, and a steeper one with more friction."""
    _, way, _ = slide(APIC, np.radians(24.0), np.radians(24.0), 5.0)
    assert way[-1] == pytest.approx(19.85947, rel=0.005)  # a step of the last fifty beyond 5 s, and the first hop
    assert measured_acceleration(APIC, np.radians(35.0), np.radians(35.0), 1.0, 0.47) == pytest.approx(1.84992051,
                                                                                                      rel=0.002)


@pytest.mark.parametrize("tilt", [0, 12, 37])
def test_no_creep_below_the_friction_angle(tilt):
    time, way, _ = slide(APIC, np.radians(12.0), np.radians(tilt), 1.0)
    settled = way[time > 0.3]  # what the springs of block and wall give way at first
    assert np.ptp(settled) < 1e-4 * DX and abs(settled[-1]) < 0.05 * DX


@pytest.mark.slow
@pytest.mark.parametrize("tilt", [0, 30])
def test_no_creep_in_ten_seconds(tilt):
    time, way, _ = slide(APIC, np.radians(12.0), np.radians(tilt), 10.0)
    assert np.ptp(way[time > 0.3]) < 1e-3 * DX
