"""Friction of grains on a ground that water presses on as well: Coulomb's law of the effective stress."""

import pytest

from snowmpm.running.simulation import Simulation
from tests.support.two_velocities import DX, MEDIUM, phases, run_to, scene

MU, G, DEEP, N = 0.4, 9.81, 0.2, 0.4
SATURATED, BUOYANT = 2000.0, 1000.0


def sliding(medium=None, surface=None, **water):
    """`Simulation` of a saturated layer without an end on level ground, sliding at 1 m/s."""
    side = 8 * DX
    made = scene((side, DEEP), {"table": DEEP, **water}, gravity=G, materials={"soil": {**MEDIUM, **(medium or {})}},
                 domain={"min": [0.0, -2.0 * DX], "max": [side, 6.0 * DX],
                         "boundary": {"x_min": "periodic", "x_max": "periodic"}},
                 bodies=[{"name": "layer", "material": "soil", "velocity": [1.0, 0.0],
                          "shape": {"kind": "box", "min": [0.0, 0.0], "max": [side, DEEP]}}],
                 terrain={"kind": "plane", "angle": 0.0, "contact": "slip", "friction": MU, **(surface or {})})
    return Simulation(made)


def slowed(simulation, begin, end):
    """Mean deceleration [m/s2] of grains and water between two times [s]."""
    start = run_to(simulation, begin).audit()
    row = run_to(simulation, end).audit()
    assert row["momentum_residual"] < 1e-12
    return (start["momentum_x"] - row["momentum_x"]) / row["mass"] / (end - begin)


def test_friction_of_the_buoyant_weight():
    """Once the layer has settled, pressures are hydrostatic: a = mu g (rho - rho_w) / rho, half of that of dry soil;
    drag slows the water with the grains."""
    simulation = sliding()
    assert slowed(simulation, 0.03, 0.06) == pytest.approx(MU * G * BUOYANT / SATURATED, rel=0.02)
    fields, wet = simulation.particles, phases(simulation)
    assert fields["velocity"][wet, 0].mean() == pytest.approx(fields["velocity"][~wet, 0].mean(), abs=0.005)


def test_water_that_bears_the_weight_takes_the_friction():
    """Undrained grains get M / (M + K_w / n) of their buoyant weight; that of the half cell at the ground is not told
    from it, since the scheme knows no pressure there but that of cells.

    The rows of particles at 1/4, 3/4 and 5/4 of a cell give the nodes at the ground and below it (1 + 1/32) / 2 of the
    weight of a cell. Put on at once, it swings: the mean of 1 - cos(w t) since the start is at most 1 - min sin(x) / x
    = 1.2172 of the weight at rest.
    """
    M, K_w = 1e6, 1e7
    found = slowed(sliding({"youngs_modulus": M}, permeability=1e-14, bulk_modulus=K_w), 0.0, 0.03)
    buoyant = MU * G * BUOYANT / SATURATED
    assert 0.0 < found - buoyant * M / (M + K_w / N) < 1.2172 * (1.0 + 1.0 / 32.0) * buoyant * 0.5 * DX / DEEP


def test_dry_grains():
    """The same surface, where the table lies below: mu g; the layer bounces a little."""
    simulation = sliding(table=1e-6 * DX)
    assert not phases(simulation).any()
    assert slowed(simulation, 0.0, 0.06) == pytest.approx(MU * G, rel=0.03)
