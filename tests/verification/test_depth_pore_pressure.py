"""Excess pore pressure in a depth-averaged flow: a drying column (P7), a dam break dry, saturated and liquefied (P8).

P7: dp/dT = d2p/d eta2 with p = 0 at the water table, dp/d eta = 0 at a sealed bed or p = 0 at a drained one, from
p = 1 - eta:

    sealed   p(0, T) = sum_k 2 / m^2 exp(-m^2 T),   m = (k + 1/2) pi
"""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import solve_banded

from snowmpm.ground import Coulomb
from tests.support.depth_flows import (
    OPEN,
    UNDAMPED,
    USUAL,
    WALL,
    G,
    Ground,
    coulomb,
    flat,
    flow,
    lattice,
    order,
    pore_water,
    run_to,
    slope,
)

CV, DEEP = 0.01, 2.0
"""c_v [m2/s] and depth [m] of a column at rest"""
SEALED = {0.05: 0.747687, 0.1: 0.643177, 0.2: 0.495912, 0.5: 0.236050, 1.0: 0.068740}
"""Pressure at the bed over that of the start, by T = c_v t / d^2"""
GRAINS, PORES = 2500.0, 0.3
DRY, WET = 1750.0, 2050.0
BORNE = WET - 1000.0
"""Densities of grains, dry and wet skeleton, and what the skeleton bears under hydrostatic water [kg/m3]; porosity"""


def still(layers=16, precision="f64", **water):
    """Columns that lie on flat ground between walls."""
    plan, area = lattice((0.0, 0.0), (4.0, 4.0), 0.5)
    pores, dry = pore_water(consolidation=CV, layers=layers, **water)
    return flow(plan, area * DEEP, Ground(flat, (0.0, 0.0), (4.0, 4.0), coulomb(20.0), (WALL, WALL)), 1.0,
                densities=(dry,), water=pores, options=replace(USUAL, precision=precision))


def at_bed(solver):
    return solver.particles.column("excess_pressure")[:, 0]


def drying(solver, times, share):
    """Pressure at the bed over that of the start at times T, in steps of a share of the T that is to come."""
    start, unit, seen = at_bed(solver), DEEP**2 / CV, []
    for time in times:
        run_to(solver, time * unit, share * unit)
        seen.append((at_bed(solver) / start).mean())
    return np.array(seen)


def test_a_column_that_dries():
    """P7, sealed: the pressure at the bed to 0.3 % of what is left with 16 layers, of second order in them."""
    expected = np.array(list(SEALED.values()))
    errors = [np.abs(drying(still(layers, excess=1.0), SEALED, 0.01) / expected - 1.0).max() for layers in (8, 16, 32)]
    assert errors[1] < 0.003
    assert order(errors).min() > 1.9


@pytest.mark.parametrize("precision", ["f32", "f64"])
def test_the_start_is_liquefied(precision):
    """Pressure at the bed under hydrostatic and excess pressure, before and after a step, and what is read."""
    solver = still(precision=precision, excess=1.0)
    for _ in range(2):
        water = solver.particles.column("water")
        np.testing.assert_allclose(at_bed(solver), BORNE * G * DEEP, rtol=2e-3 if solver.steps else 1e-6)
        np.testing.assert_allclose(water[:, 1] - at_bed(solver), 1000.0 * G * DEEP, rtol=1e-6)
        np.testing.assert_allclose(water[:, [0, 2]], np.broadcast_to([300.0, 0.7], (len(water), 2)))
        run_to(solver, 1e-3)


def test_a_drained_bed_against_an_own_solution():
    """Over a bed that drains, the profile follows an own fully implicit solution in small steps, to 0.2 % of the start;
    between them the base is 0."""
    solver, unit = still(32, excess=1.0, drained=True), DEEP**2 / CV
    run_to(solver, 0.1 * unit, 0.002 * unit)
    seen = solver.particles.load.pores.profile()[0] / (BORNE * G * DEEP)
    n, steps = 32, 20000
    z = 0.1 / steps * n**2
    bands = np.array([np.full(n - 1, -z), np.full(n - 1, 1.0 + 2.0 * z), np.full(n - 1, -z)])
    p = 1.0 - np.arange(1, n) / n
    for _ in range(steps):
        p = solve_banded((1, 1), bands, p)
    np.testing.assert_allclose(seen[1:-1], p, atol=2e-3)
    assert seen[0] == seen[-1] == 0.0


def test_second_order_in_time():
    """Ten, twenty and forty steps to T = 0.5 against 400, of the same mesh; one step to T = 100 leaves next to
    nothing."""
    exact, *seen = (drying(still(excess=1.0), [0.5], share)[0] for share in (0.0025, 0.1, 0.05, 0.025))
    assert order(np.abs(np.array(seen) - exact)).min() > 1.7
    assert abs(drying(still(excess=1.0), [100.0], 1.0)[0]) < 0.02


def test_water_that_fills_a_part_of_the_pores():
    """Water to half the depth: T goes with its depth, the load of the dry snow above it is borne too, and what the
    skeleton bears is the weight less that of the water's pressure."""
    solver = still(32, excess=1.0, level=0.5)
    borne = 1750.0 + 150.0 - 500.0
    np.testing.assert_allclose(at_bed(solver), borne * G * DEEP, rtol=1e-12)
    assert drying(solver, [0.05], 0.0005)[0] == pytest.approx(SEALED[0.2], rel=1e-3)


def sheet(angle, mu, *, water=None, density=DRY, length=40.0, deep=1.0, ground=None, stop=400.0):
    """Columns on a plane, in a channel of three cells."""
    plan, area = lattice((0.0, 0.0), (length, 3.0), 0.5)
    bed = Ground(ground or slope(angle), (-5.0, 0.0), (stop, 3.0), Coulomb(mu=mu), (OPEN, WALL))
    return flow(plan, area * deep, bed, 1.0, densities=(density,), water=water, options=UNDAMPED)


def speeds(solver):
    return np.linalg.norm(solver.particles.column("velocity"), axis=1)


@pytest.mark.parametrize(("water", "share"), [
    ({"excess": 0.4}, 0.6 * BORNE / WET),
    ({"drained": True, "excess": 1.0}, BORNE / WET),
    ({"excess": 1.0}, 0.0),
    ({"level": 0.5, "excess": 0.5}, 0.5 * 1400.0 / 1900.0),
])
def test_friction_of_what_the_skeleton_bears(water, share):
    """Weight and thickness that stay: a block on 30 degrees speeds up with g (sin - share mu cos), share what the
    skeleton bears of the weight. The middle of a sheet of 40 m, for a second."""
    angle, mu = 30.0, 0.5
    pores, dry = pore_water(**water)
    solver = run_to(sheet(angle, mu, water=pores, density=dry), 1.0)
    x = solver.particles.positions()[:, 0]
    middle = np.abs(x - np.median(x)) < 2.0
    expected = G * (np.sin(np.radians(angle)) - share * mu * np.cos(np.radians(angle)))
    np.testing.assert_allclose(speeds(solver)[middle], expected, rtol=1e-4)


def test_liquefied_snow_stays_liquefied():
    """Without drainage, load and pressure change together: on a curved way, thickening and thinning, snow that is
    liquefied slides as on ice, to round-off of single steps; its mesh follows the load."""
    def path(plan):
        return 0.004 * np.maximum(0.0, 60.0 - plan[:, 0]) ** 2

    wet, dry = pore_water(excess=1.0)
    solvers = [run_to(sheet(0.0, mu, water=wet, density=dry, length=20.0, ground=path), 5.0, 0.02) for mu in (0.0, 0.5)]
    np.testing.assert_allclose(speeds(solvers[1]), speeds(solvers[0]), rtol=1e-9)
    assert np.ptp(at_bed(solvers[1])) > 0.5 * at_bed(solvers[1]).max()


def test_grains_without_excess_pressure_bear_the_weight_under_water():
    """With a drained bed, the flow is that of a lesser friction, mu rho' / rho, over the whole of a dam's break."""
    wet, dry = pore_water(drained=True)
    seen = [run_to(sheet(10.0, mu, water=water, density=density, length=10.0), 2.0, 0.01)
            for mu, water, density in ((0.4, wet, dry), (0.4 * BORNE / WET, None, WET))]
    np.testing.assert_allclose(seen[1].particles.positions(), seen[0].particles.positions(), rtol=1e-9)
    assert seen[0].contact_work == pytest.approx(seen[1].contact_work, rel=1e-9)


def test_a_drain_holds_the_snow_back():
    """Liquefied snow crosses a strip of drained ground: pressure at the ground is 0 over it, and comes back behind it
    from within the column."""
    def strip(plan):
        return (plan[:, 0] > 50.0) & (plan[:, 0] < 60.0)

    pores, dry = pore_water(excess=1.0, consolidation=0.002, drained=strip)
    solver = sheet(20.0, 0.5, water=pores, density=dry, length=10.0, deep=0.5)
    over, behind = [], []
    while solver.time < 7.0:
        solver.step(0.02)
        x, p = solver.particles.positions()[:, 0], at_bed(solver)
        over.append(np.abs(p[(x > 50.5) & (x < 59.5)]).max(initial=0.0))
        behind.append(p[x > 65.0].max(initial=0.0))
    assert max(over) == 0.0 < max(behind)
