"""Grains and water with a velocity each, settled before time zero: effective stress of the buoyant weight."""

import numpy as np
import pytest

from snowmpm.running.simulation import Simulation
from tests.support.same_runs import assert_goes_on_alike
from tests.support.two_velocities import DX, in_tub, phases, run_to, scene
from tests.support.water_masses import assert_masses_close, audited

DEEP, G, BUOYANT = 0.4, 9.81, 2000.0 - 1000.0
SETTLE = {"initial": {"stress": "settle", "tolerance": 0.01}}


def soaked(**changes):
    """`Simulation` of saturated soil at rest in a tub, which lets little water through."""
    return in_tub((DEEP, DEEP), (DEEP, 0.6), {"permeability": 1e-10, "bulk_modulus": 4e5, "table": DEEP}, gravity=G,
                  **changes)


@pytest.fixture(scope="module")
def settled():
    """At time zero, its fields then, and the rows of the audit of the 0.05 s that follow."""
    simulation = soaked(**SETTLE)
    first = simulation.particles
    return simulation, first, audited(simulation, 0.05, every=10)


def test_water_keeps_its_pressure(settled):
    simulation, first, _ = settled
    wet = phases(simulation)
    z = first["position"][wet, 1]
    np.testing.assert_allclose(first["pore_pressure"][wet], 1000.0 * G * (DEEP - z), atol=10.0)
    assert simulation.settling_steps > 0 and np.abs(first["velocity"]).max() < 0.01 * (G * DEEP) ** 0.5


def test_grains_bear_the_buoyant_weight(settled):
    """Row by row of the cells between the ground and the surface, to 3 %."""
    simulation, first, _ = settled
    grains = ~phases(simulation)
    z, stress = first["position"][grains, 1], first["stress"][grains, 1]
    row = (z / DX).astype(int)
    found = (np.bincount(row, stress) / np.bincount(row))[1:-1]
    np.testing.assert_allclose(found, -BUOYANT * G * (DEEP - DX * (np.arange(1, len(found) + 1) + 0.5)), rtol=0.03)


def test_nothing_moves_afterwards(settled):
    """Grains that begin without stress fall until the water bears them; after settling they stay."""
    simulation, _, rows = settled
    assert assert_masses_close(rows) > 10 and rows[0]["water_mass"] == pytest.approx(400.0 * DEEP**2, rel=1e-10)
    assert rows[0]["contact_work"] == rows[0]["water_work"] == 0.0 and rows[-1]["momentum_residual"] < 1e-10
    loose = run_to(soaked(), 0.05).audit()
    assert max(row["kinetic_energy"] for row in rows) < 0.02 * loose["kinetic_energy"]
    wet, now = phases(simulation), simulation.particles
    expected = 1000.0 * G * (DEEP - now["position"][wet, 1])
    np.testing.assert_allclose(now["pore_pressure"][wet], expected, atol=0.05 * 1000.0 * G * DEEP)


@pytest.mark.parametrize("surface", [{"contact": "stick"}, {"contact": "slip", "friction": 0.6}])
def test_water_stays_in_snow_on_a_slope(surface):
    """It neither runs out nor along the ground, which holds it as it holds the grains; afterwards it begins to run."""
    shape = {"kind": "layer", "bottom": 0.0, "top": 0.2, "region": {"x": [0.0, 0.5]}}
    simulation = Simulation(scene((0.5, 0.2), {"permeability": 1e-8, "bulk_modulus": 4e5}, gravity=G,
                                  domain={"min": [-0.5, -0.5], "max": [1.5, 0.5]},
                                  terrain={"kind": "plane", "angle": 15.0, **surface},
                                  bodies=[{"name": "layer", "material": "soil", "shape": shape}], **SETTLE))
    wet, fields = phases(simulation), simulation.particles
    places = fields["position"][np.argsort(fields["id"])]
    n = len(places) // 2
    np.testing.assert_allclose(places[n:], places[:n], atol=1e-3)  # water lies where its grains do
    rest = np.abs(fields["velocity"][wet]).max()
    later = run_to(simulation, 0.03).particles["velocity"][wet, 0].mean()
    assert rest < 0.01 * (G * 0.2) ** 0.5 < later


def test_goes_on_to_the_bit_without_settling_anew(tmp_path):
    """Under rain, whose drops have numbers after those of the start."""
    rain = {"events": [{"kind": "rain", "rate": 2000.0}]}
    whole = run_to(soaked(**SETTLE, **rain), 0.02)
    assert whole.audit()["added_water"] > 0.0
    other = assert_goes_on_alike(whole, 0.03, tmp_path, resumed=tmp_path)
    assert other.settling_steps == 0 < whole.settling_steps  # it does not settle
