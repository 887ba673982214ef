"""Water through a dam of rockfill (P9): what runs off is what comes in, and the surface stands where Dupuit has it."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from snowmpm.running.simulation import Simulation
from snowmpm.scenes import load_scene
from tests.support.project import ROOT

SCENE = ROOT / "docs" / "rockfill_dam.toml"
FLOW = 24.46e-3 / 2.46
POROSITY, STONE, PERMEABILITY = 1.0 - 1546.5 / 2600.0, 0.03504, 1.539e-6
FOOT, SLOPE = 3.2, 1.5


def fall_of_head(u):
    """-dh/dx of a discharge u [m/s] per area through the stones, by Ergun's equation."""
    w = u / POROSITY
    return (POROSITY * 1e-3 / PERMEABILITY * w
            + 1.75 * 1000.0 * (1.0 - POROSITY) / (POROSITY * STONE) * w**2) / (1000.0 * 9.81)


def dupuit(x):
    """Depth [m] at x (k,) [m] of a hydrostatic flow along the floor, from where it leaves the lower side by the
    gradient of that side."""
    trial = np.linspace(0.005, 0.5, 5000)
    exit_depth = trial[np.argmin(np.abs(fall_of_head(FLOW / trial) - 1.0 / SLOPE))]
    start = FOOT - SLOPE * exit_depth
    found = solve_ivp(lambda s, h: fall_of_head(FLOW / h), (0.0, start), [exit_depth], dense_output=True, rtol=1e-8)
    return found.sol(start - np.asarray(x))[0]


def depths(simulation, places):
    """From the pressure of the water near the floor around each of the places [m]."""
    fields, dx = simulation.particles, simulation.scene.solver.dx
    low = (fields["material"] == 1) & (fields["position"][:, 1] < 1.5 * dx)
    x, z = fields["position"][low].T
    head = z + fields["pore_pressure"][low] / 9810.0
    return np.array([head[np.abs(x - place) < 1.5 * dx].mean() for place in places])


@pytest.mark.slow
def test_rockfill_dam():
    """24.46 L/s within 5 %, over the last 20 s of 80; the free surface is steady, to half a spacing, and within 5 % of
    Dupuit's, which knows nothing of particles; water closes."""
    simulation, seen = Simulation(load_scene(SCENE)), []
    places = np.array([0.5, 1.0, 1.5, 2.0, 2.5])
    for time in np.arange(56.0, 81.0, 1.0):
        while simulation.time < time - 1e-9:
            simulation.step(until=time)
        seen.append([simulation.audit()["removed_water"] / 1000.0, *depths(simulation, places)])
    out, surface = np.array(seen)[:, 0], np.array(seen)[:, 1:]
    flow, first, last = (out[-1] - out[-21]) / 20.0, surface[:8].mean(axis=0), surface[-8:].mean(axis=0)
    print("flow", flow / FLOW, "surface", last, "dupuit", dupuit(places), "before", first)
    assert flow == pytest.approx(FLOW, rel=0.05)
    assert np.abs(last - first).max() < 0.5 * simulation.scene.solver.dx
    np.testing.assert_allclose(last, dupuit(places), rtol=0.05)
    row = simulation.audit()
    assert row["water_residual"] < 1e-10 and row["momentum_residual"] < 1e-10
