"""A piston drives a compaction wave into snow (M10), exact: fronts of a rate-independent material in uniaxial strain.

Up to the final strain e1 = 1 - rho0 / rho1 the wave follows the upper concave hull of the nominal stress P(e) of
the oedometric path: Lagrangian speed sqrt(P' / rho0), piston speed V = integral of sqrt(hull' / rho0) de. The last,
straight part of the hull is the shock, of speed D. P(e) from the ordinary differential equations of cohesive Cam-Clay.

dx = 0.01 m. The column is long enough that the elastic precursor does not come back from its free end.
"""

import numpy as np
import pytest

from snowmpm.materials import CohesiveCamClay
from snowmpm.mpm.solver import MpmSolver
from snowmpm.population import Population
from tests.verification.particle_states import ParticleStates
from tests.verification.rigid_walls import block
from tests.verification.schemes import APIC, FLIP, lattice

DX, WIDTH, WAY = 0.01, 0.04, 0.5
FIRM = CohesiveCamClay(density=250.0, youngs_modulus=3e6, poisson_ratio=0.3, critical_slope=1.5, cohesion=0.3,
                       hardening=1.0, p0=30e3)
FRESH = CohesiveCamClay(density=200.0, youngs_modulus=3e6, poisson_ratio=0.3, critical_slope=0.7, cohesion=0.2,
                        hardening=0.002, p0=3e3)
# speed of the piston: D [m/s], P1 [Pa], rho1 [kg/m3]
FRONTS = {("firm", 4.3): (83.83, 101973.0, 262.3), ("fresh", 1.0): (7.05, 4345.0, 228.0),
          ("fresh", 4.3): (9.47, 11005.0, 357.5)}


def drive(law, scheme, speed, front, length):
    """-> Lagrangian speed of the front [m/s], stress on the piston [Pa], density behind the front [kg/m3], plastic
    work [J]."""
    expected, _, density = front
    piston = block([0.0, WIDTH / 2], [1.0, 0.0], 2.0, "slip", velocity=[speed, 0.0])
    positions, volumes = lattice([0.0, 0.0], [length, WIDTH], DX)
    solver = MpmSolver(Population(positions, volumes, 0), [law], dx=DX, precision="f64", origin=np.array([-0.1, 0.0]),
                       lower=np.array([-0.1, 0.0]), upper=np.array([1.5 * length, WIDTH]), gravity=np.zeros(2),
                       sides=[["open", "open"], ["slip", "slip"]], obstacles=[piston], **scheme.options)
    states, rows, middle = ParticleStates(solver), [], 0.5 * (1.0 + law.density / density)
    while not rows or (rows[-1][1] < WAY and solver.time < 1.5 * WAY / expected):
        for _ in range(4):
            solver.step(solver.stable_dt()[0])
        crushed = solver.particles.column("volume_ratio")[:, 0] < middle
        rows.append((solver.time, crushed.mean() * length, -solver.obstacle_totals[0, 0] / WIDTH))
    time, place, impulse = np.array([row for row in rows if row[1] > 0.3 * WAY]).T
    behind = (states.reference[:, 0] > 5 * DX) & (states.reference[:, 0] < WAY - 10 * DX)
    ratio = states.column("volume_ratio")[behind, 0]
    return (np.polyfit(time, place, 1)[0], np.polyfit(time, impulse, 1)[0], (law.density / ratio).mean(),
            solver.plastic_work)


@pytest.mark.parametrize(("law", "kind", "speed", "length", "scheme"), [
    (FIRM, "firm", 4.3, 1.5, APIC), (FIRM, "firm", 4.3, 1.5, FLIP),
    pytest.param(FRESH, "fresh", 1.0, 4.5, APIC, marks=pytest.mark.slow)], ids=str)
def test_front_and_what_it_leaves(law, kind, speed, length, scheme):
    D, P, density = FRONTS[kind, speed]
    front, stress, behind, work = drive(law, scheme, speed, (D, P, density), length)
    assert front == pytest.approx(D, rel=0.03) and stress == pytest.approx(P, rel=0.03)
    assert behind == pytest.approx(density, rel=0.02) and work > 0.0


@pytest.mark.slow
def test_speed_of_the_front_in_fresh_snow():
    D, P, density = FRONTS["fresh", 4.3]
    assert drive(FRESH, APIC, 4.3, (D, P, density), 4.5)[0] == pytest.approx(D, rel=0.03)


@pytest.mark.slow
@pytest.mark.xfail(strict=True, reason="what rings behind the front is crushed too far, then unloads: stress 4 % low,"
                                       " density 2.3 % high, on any grid; it wants an artificial viscosity")
def test_state_behind_the_front_in_fresh_snow():
    D, P, density = FRONTS["fresh", 4.3]
    _, stress, behind, _ = drive(FRESH, APIC, 4.3, (D, P, density), 4.5)
    assert stress == pytest.approx(P, rel=0.03) and behind == pytest.approx(density, rel=0.02)
