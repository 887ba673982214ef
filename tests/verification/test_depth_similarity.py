"""A parabolic pile on a plane with Coulomb friction (D5): it stays one (numbers of M20).

    h = H / (g f) (1 - (x - X)^2 / (g L)^2 - y^2 / (f L)^2),  X = (A - C) g t^2 / 2

x along the plane at 35 degrees, friction 25 degrees, A = sin zeta, C = cos zeta tan delta. With T = sqrt(L / g) as unit
of time,

    g'' = 2 B / (g^2 f),  f'' = 2 D / (g f^2) - C f' / ((A - C) t),  B = D = H / L cos zeta

Hutter's similarity solution, as AvaFrame's com1DFA is tested with it. It takes the friction across the way in
proportion to y' / X', so for a pile that slides much faster than it spreads: at first it does not, and ours, which acts
against the velocity of each column, leaves the centre 0.3 % further after 5 s and 10 s, at any spacing.
"""

import functools

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from tests.support.depth_flows import G, Ground, coulomb, depths, flow, front, lattice, order, run_to, slope

SLOPE, FRICTION = 35.0, 25.0
LENGTH, HEIGHT = 80.0, 4.0
THIN = 0.05
"""Depth [m] at which a front is taken: 1.3 to 2 % of the largest."""
COS = np.cos(np.radians(SLOPE))


def theory(time):
    """Stretch along and across, way of the centre [m]."""
    a, c = np.sin(np.radians(SLOPE)), COS * np.tan(np.radians(FRICTION))
    b = HEIGHT / LENGTH * COS

    def rates(t, y):
        along, across, _, widening = y
        drag = c * widening / ((a - c) * t) if t > 0.0 else 0.0
        return [y[2], widening, 2.0 * b / (along**2 * across), 2.0 * b / (along * across**2) - drag]

    y = solve_ivp(rates, (0.0, time / np.sqrt(LENGTH / G)), [1.0, 1.0, 0.0, 0.0], rtol=1e-10, atol=1e-12).y[:, -1]
    return y[0], y[1], 0.5 * (a - c) * G * time**2


def test_theory():
    """Against the numbers of the case."""
    along, across, centre = theory(5.0)
    found = [along, across, centre, HEIGHT / along / across, centre + LENGTH * along]
    np.testing.assert_allclose(found, [1.1199810, 1.0395397, 23.4949, 3.43564, 113.0934], rtol=2e-6)
    along, across, centre = theory(10.0)
    np.testing.assert_allclose([along, across, HEIGHT / along / across, centre + LENGTH * along],
                               [1.4308628, 1.1369392, 2.45881, 208.4486], rtol=2e-6)


@functools.cache
def found(dx, time):
    """Quantities of a run over those of the theory: depth, centre and front, lengths along and across, and the error of
    all depths over all of them. dx in plan [m]; 9 columns a cell."""
    plan, area = lattice((-LENGTH * COS, -LENGTH), (LENGTH * COS, LENGTH), dx / 3)
    depth = HEIGHT * (1.0 - (plan[:, 0] / COS / LENGTH) ** 2 - (plan[:, 1] / LENGTH) ** 2)
    inside = depth > 0.0
    along, across, centre = theory(time)
    top = HEIGHT / (along * across)
    ground = Ground(slope(SLOPE), (-LENGTH * COS - 5.0 * dx, -LENGTH * across - 5.0 * dx),
                    ((centre + LENGTH * along) * COS + 8.0 * dx, LENGTH * across + 5.0 * dx), coulomb(FRICTION))
    solver = run_to(flow(plan[inside], depth[inside] * area / COS, ground, dx), time)
    mass, place = solver.particles.masses(), solver.particles.positions()
    x, y = place[:, 0] / COS, place[:, 1]
    middle = np.average(x, weights=mass)
    places, vertical = depths(solver)
    nodes, across_nodes, h = places[..., 0] / COS, places[..., 1], vertical * COS
    exact = np.maximum(0.0, top * (1.0 - ((nodes - centre) / (LENGTH * along)) ** 2
                                   - (across_nodes / (LENGTH * across)) ** 2))
    in_the_middle = np.abs(across_nodes[0]) < 0.51 * dx
    edge = front(nodes[:, 0], h[:, in_the_middle].mean(axis=1), THIN)
    return {"depth": h.max() / top, "centre": middle / centre,
            "front": edge / (centre + LENGTH * along * np.sqrt(1.0 - THIN / top)),
            "along": np.sqrt(6.0 * np.average((x - middle) ** 2, weights=mass)) / (LENGTH * along),
            "across": np.sqrt(6.0 * np.average(y**2, weights=mass)) / (LENGTH * across),
            "all": 1.0 + np.abs(h - exact).sum() / exact.sum()}


@pytest.mark.parametrize("time", [5.0, 10.0])
@pytest.mark.parametrize("quantity", ["depth", "centre", "front", "along", "across", "all"])
def test_pile(quantity, time):
    """Within 2 % at 20 cells of the half-length. Seen: depth 0.2 and 0.1 %, centre 0.3 %, front 0.2 and 0.9 %, lengths
    0.2 and 0.5 %, all depths 0.7 and 1.6 %, the theory's share of which is the shift of the centre."""
    assert found(4.0, time)[quantity] == pytest.approx(1.0, abs=0.02)


def test_order():
    """Of the stretch along the way after 5 s: the spline makes a layer dx / 2 wider, in its variance. Seen: 1.5 and
    1.3. The centre, which the theory misses by 0.3 %, has none."""
    errors = np.abs([found(dx, 5.0)["along"] - 1.0 for dx in (8.0, 4.0, 2.0)])
    assert order(errors).min() > 1.0
    centres = [found(dx, 5.0)["centre"] for dx in (8.0, 4.0, 2.0)]
    assert np.ptp(centres) < 5e-4
