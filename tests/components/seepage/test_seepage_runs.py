"""SPH of seepage in runs: rest, drag, both masses, rain, resume."""

import numpy as np
import pytest

from tests.support.same_runs import assert_goes_on_alike
from tests.support.seeping import DX, POROSITY, seeping, wet
from tests.support.water_masses import assert_masses_close, audited

RAIN = {"events": [{"kind": "rain", "rate": 100.0, "start": 0.05, "region": {"x": [0.5, 1.0]}}]}


@pytest.fixture(scope="module")
def rained():
    """A block of soil, soaked to 0.3 m, beside which it rains into a tub that water leaves over its open side."""
    simulation = seeping(sides={"x_max": "open"}, water={"table": 0.3}, **RAIN)
    return simulation, audited(simulation, 2.0)


def test_masses(rained):
    """Of grains and of water, rain and what left counted, to 1e-10 in every audit; momentum closes; grains rest."""
    simulation, rows = rained
    assert assert_masses_close(rows) > 100
    start, row, soil = rows[0], rows[-1], ~wet(simulation)
    assert row["momentum_residual"] < 1e-10
    assert row["removed_water"] > 0.0
    assert start["water_mass"] == pytest.approx(1000.0 * POROSITY * 0.5 * 0.3, rel=1e-12)
    # Whole particles, of POROSITY dx² each: some of it is still owed in the five columns
    fell = 100.0 * 0.5 * (simulation.time - 0.05)
    assert fell - 5.0 * 1000.0 * POROSITY * DX**2 < row["added_water"] <= fell + 1e-9
    assert row["mass"] - row["water_mass"] == pytest.approx(start["mass"] - start["water_mass"], rel=1e-12)
    assert (simulation.particles["velocity"][soil] == 0.0).all() and soil.sum() == 30


def test_pressure_at_rest():
    """Of soaked soil: hydrostatic, with the surface to half a row of particles."""
    simulation = seeping((1.0, 0.6), water={"table": 0.6})
    while simulation.time < 3.0:
        simulation.step(until=3.0)
    fields, water = simulation.particles, wet(simulation)
    z, p = fields["position"][water, 1], fields["pore_pressure"][water]
    expected = 9810.0 * (0.6 - z)
    np.testing.assert_allclose(p, expected, atol=9810.0 * DX)
    assert p.mean() == pytest.approx(expected.mean(), abs=0.5 * 9810.0 * DX)
    assert np.polyfit(z, p, 1)[0] == pytest.approx(-9810.0, rel=0.05)
    assert np.abs(fields["velocity"][water]).max() < 0.01 * (2.0 * 9.81 * 0.6) ** 0.5


def test_darcy_column():
    """Water that falls through a tall column at p = 0: w = K rho g / (mu n) to 0.1 % (P10); by Ergun's drag, whose
    pressure of the start takes longer to go, the root of a w + b w² = rho g n to 2 %."""
    for size, tolerance in ((None, 1e-3), (5e-3, 2e-2)):
        simulation = seeping((0.5, 1.0), (0.5, 1.0), sides={"z_min": "open"},
                             water={"permeability": 1e-8, **({"grain_size": size} if size else {})})
        while simulation.time < 1.0:
            simulation.step(until=1.0)
        fields, water = simulation.particles, wet(simulation)
        middle = water & (np.abs(fields["position"][:, 1] - 0.6) < 0.2)
        a, drive = POROSITY**2 * 1.792e-3 / 1e-8, POROSITY * 1000.0 * 9.81
        b = 1.75 * 1000.0 * (1.0 - POROSITY) / size if size else 0.0
        expected = (np.sqrt(a**2 + 4.0 * b * drive) - a) / (2.0 * b) if size else drive / a
        assert -fields["velocity"][middle, 1].mean() == pytest.approx(expected, rel=tolerance)


def test_a_resumed_run_is_the_same_to_the_bit(tmp_path):
    """Also of drops that fell, and of what is owed of the next."""
    whole = seeping(sides={"x_max": "open"}, water={"table": 0.3}, **RAIN)
    while whole.time < 0.6:
        whole.step(until=0.6)
    assert whole.audit()["added_water"] > 0.0
    assert_goes_on_alike(whole, 1.0, tmp_path)
