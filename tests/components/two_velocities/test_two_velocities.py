"""Grains and water with a velocity each (v-w): drag, pressure, both masses, water that pools."""

import numpy as np
import pytest

from snowmpm.water.drag import Darcy, Forchheimer
from tests.support.same_runs import assert_goes_on_alike
from tests.support.soaked_column import consolidation, terzaghi
from tests.support.two_velocities import DX, MEDIUM, around, in_tub, phases, run_to, set_velocities
from tests.support.water_masses import assert_masses_close, audited

RHO_G, RHO_W, N = 1600.0, 1000.0 * 0.4, 0.4


@pytest.mark.parametrize(("permeability", "dt", "dimension"), [
    (1e-7, 1e-4, 2), (1e-7, 2e-4, 2), (1e-12, 1e-4, 2), (1e-7, 1e-4, 3)])
def test_drag_takes_the_slip(permeability, dt, dimension):
    """u = u_0 exp(-l t), l = C (1 / rho_s + 1 / rho_w), to round-off for any step, also where l dt = 3e3 (P10); the
    momentum stays, and what drag took is the energy that is missing."""
    simulation = around({"permeability": permeability}, dimension, solver={"dt": dt})
    slip = np.array([0.1, -0.05] if dimension == 2 else [0.1, 0.02, -0.05])
    set_velocities(simulation, 0.0 * slip, slip)
    before = simulation.audit()
    for _ in range(10):
        simulation.step()
    fields, row, wet = simulation.particles, simulation.audit(), phases(simulation)
    rate = Darcy(permeability / 1.792e-3).coefficient(N, 0.0) * (1.0 / RHO_G + 1.0 / RHO_W)
    found = fields["velocity"][wet].mean(axis=0) - fields["velocity"][~wet].mean(axis=0)
    expected = slip * np.exp(-rate * 10 * dt)
    # The table of the drag by porosity has 257 entries
    np.testing.assert_allclose(found, expected, rtol=2e-4 * max(1.0, rate * 10 * dt), atol=1e-12)
    assert row["momentum_x"] == pytest.approx(before["momentum_x"], rel=1e-12)
    lost = before["kinetic_energy"] - row["kinetic_energy"]
    assert row["contact_work"] == pytest.approx(lost, rel=1e-6)
    assert row["water_residual"] < 1e-14


def test_inertia_of_fast_flow():
    """Forchheimer's part of the drag, by steps that follow it: du/dt = -(a + b |u|) u has a closed form."""
    simulation = around({"permeability": 1e-6, "grain_size": 2e-3}, solver={"dt": 1e-4})
    set_velocities(simulation, (0.0, 0.0), (0.5, 0.0))
    for _ in range(40):
        simulation.step()
    law, masses = Forchheimer(1e-6 / 1.792e-3, 2e-3), 1.0 / RHO_G + 1.0 / RHO_W
    a = law.coefficient(N, 0.0) * masses
    b = law.coefficient(N, 1.0) * masses - a
    fallen = np.exp(-a * simulation.time)
    expected = a * 0.5 * fallen / (a + b * 0.5 * (1.0 - fallen))
    v, wet = simulation.particles["velocity"][:, 0], phases(simulation)
    assert v[wet].mean() - v[~wet].mean() == pytest.approx(expected, rel=0.02)  # C is that of the start of a step


def test_darcy_flow():
    """A force f per volume drives the water one way and the grains the other, a kick before each step: the mean slip of
    a step becomes f / C, so that the discharge is Darcy's K / mu f / n, to 0.1 % (P10)."""
    dt, f = 5e-4, 100.0
    simulation = around({"permeability": 2.5e-9, "bulk_modulus": 1e5}, solver={"dt": dt})
    law = Darcy(2.5e-9 / 1.792e-3)
    rate = law.coefficient(N, 0.0) * (1.0 / RHO_G + 1.0 / RHO_W)
    store = simulation.solver.particles
    for _ in range(80):
        wet = store.labels()[:, 0] == 1
        store.accelerate(np.where(wet[:, None], f / RHO_W, -f / RHO_G) * np.array([dt, 0.0]))
        simulation.step()
    v, wet = simulation.particles["velocity"][:, 0], phases(simulation)
    slip = v[wet].mean() - v[~wet].mean() + dt * f * (1.0 / RHO_G + 1.0 / RHO_W)
    mean = slip * -np.expm1(-rate * dt) / (rate * dt)
    assert N * mean == pytest.approx(2.5e-9 / 1.792e-3 * f / N, rel=1e-3)


RAIN = {"kind": "rain", "rate": 40.0, "start": 0.1, "region": {"x": [0.2, 0.4]}}


def rained(time, tub=(0.6, 0.4)):
    """Dry soil, 0.2 m high and 0.4 m wide in a tub, on the right half of which it rains."""
    return run_to(in_tub((0.4, 0.2), tub, {"permeability": 1e-8, "bulk_modulus": 1e5, "dry": ["block"]}, gravity=9.81,
                         events=[RAIN]), time)


def test_rain_falls_on_soil_and_runs_through_it():
    """Whole drops of what rained, to 1e-10 in the balances of water and of momentum, in every audit; the first run
    through the empty pores below at K rho g / (mu n), to 1 %."""
    simulation, lowest = rained(0.0), []
    for time in (0.7, 1.1):
        assert assert_masses_close(audited(simulation, time, every=10)) > 10
        lowest.append(simulation.particles["position"][phases(simulation), 1].min())
    assert (lowest[0] - lowest[1]) / 0.4 == pytest.approx(1e-8 * 9810.0 / (1.792e-3 * N), rel=0.01)
    row, fields, wet = simulation.audit(), simulation.particles, phases(simulation)
    fell, drop = 40.0 * 0.2 * (simulation.time - 0.1), RHO_W * (0.5 * DX) ** 2
    assert fell - 8 * drop < row["added_water"] <= fell + 1e-9
    assert row["added_water"] == pytest.approx(wet.sum() * drop, rel=1e-12)
    assert row["water_mass"] == pytest.approx(row["added_water"], rel=1e-12)
    assert row["water_residual"] < 1e-10 and row["momentum_residual"] < 1e-9
    assert np.abs(fields["position"][wet, 0] - 0.3).max() < 0.1 + 0.25 * DX
    assert row["mass"] - row["water_mass"] == pytest.approx(1600.0 * 0.4 * 0.2, rel=1e-12) and (~wet).sum() == 128


def test_rain_goes_on_after_a_resume_to_the_bit(tmp_path):
    whole = rained(0.5)
    assert whole.audit()["added_water"] > 0.0
    assert_goes_on_alike(whole, 0.9, tmp_path)


def consolidating(dx, bulk_modulus, T, wide=4, dimension=2):
    """Of a column under a load that its water carries at first, at T: largest error of the pressure over p_0, how far
    its top came down and comes down in the end [m], and the row of the audit."""
    E, load, mobility = MEDIUM["youngs_modulus"], 1e4, 1e-9 / 1.792e-3
    c_v, first = mobility / (1.0 / E + N / bulk_modulus), load / (1.0 + E * N / bulk_modulus)
    plan = [wide * dx] * (dimension - 1)
    simulation = run_to(in_tub([*plan, 1.0], [*plan, 1.4], {
        "bulk_modulus": bulk_modulus, "pressure": first}, solver={"dx": dx},
        forces=[{"kind": "pressure", "value": load}]), T / c_v)
    fields, wet, rows = simulation.particles, phases(simulation), round(1.0 / dx)
    z, p = fields["position"][:, -1], fields["pore_pressure"]
    inside = wet & (z < 1.0)
    row = (z[inside] / dx).astype(int)
    mean = np.bincount(row, p[inside], rows) / np.bincount(row, minlength=rows) / first
    error = np.abs(mean - terzaghi(1.0 - (np.arange(rows) + 0.5) / rows, T)).max()
    sunk = 1.0 - fields["volume"][~wet].sum() / np.prod(plan)
    return error, sunk, load / E, simulation.audit()


def test_consolidation():
    """Terzaghi's column (P1) at T = 0.2, with water of a tenth of its stiffness; it leaves through the top."""
    error, sunk, whole, row = consolidating(DX, 2.2e8, 0.2)
    assert error < 0.05
    assert sunk == pytest.approx(whole * consolidation(0.2), rel=0.05)
    assert row["water_residual"] < 1e-10
    # Of what the load gave, what is neither stored nor drag: the start's waves, that transfers smooth. Drag by the slip
    # before walls act would be booked 8 % too large
    assert 0.0 < row["energy_remainder"] < 0.03 * row["contact_work"]


@pytest.mark.slow
def test_consolidation_in_three_dimensions():
    error, sunk, whole, row = consolidating(DX, 2.2e8, 0.2, wide=2, dimension=3)
    assert error < 0.05
    assert sunk == pytest.approx(whole * consolidation(0.2), rel=0.05)
    assert row["water_residual"] < 1e-10


@pytest.mark.slow
def test_consolidation_with_the_stiffness_of_water():
    """The case to the letter, at T = 0.2 and 0.5."""
    for T in (0.2, 0.5):
        error, sunk, whole, row = consolidating(DX, 2.2e9, T)
        assert error < 0.05
        assert sunk == pytest.approx(whole * consolidation(T), rel=0.05)
        assert row["water_residual"] < 1e-10


@pytest.fixture(scope="module")
def pooled():
    """A block of coarse soil, 0.4 m wide and high, saturated at the start, in a tub 0.8 m wide, when its water has run
    out; it holds fast to the floor."""
    simulation, levels = in_tub(*TUB, gravity=9.81), []
    start = simulation.audit()
    for time in np.arange(1.2, 1.61, 0.05):  # it still sways to and fro
        fields = run_to(simulation, time).particles
        outside = phases(simulation) & (fields["position"][:, 0] > 0.45)
        levels.append(fields["mass"][outside].sum() / 1000.0 / 0.35)
    return simulation, start, np.mean(levels)


TUB = ((0.4, 0.4), (0.8, 1.0), {"permeability": 1e-7, "bulk_modulus": 4e5, "table": 0.4}, {"z_min": "stick"})


def test_masses(pooled):
    """Of grains and of water, each to 1e-10 of the start; momentum closes."""
    simulation, start, _ = pooled
    row = simulation.audit()
    assert row["water_mass"] == pytest.approx(1000.0 * N * 0.16, rel=1e-10)
    assert row["mass"] - row["water_mass"] == pytest.approx(start["mass"] - start["water_mass"], rel=1e-10)
    assert row["water_residual"] < 1e-10 and row["momentum_residual"] < 1e-10


def test_water_leaves_and_pools(pooled):
    """One level inside and outside: n 0.4 h + 0.4 h = n 0.4 0.4, so h = 0.114 m, to a fifth of a cell."""
    simulation, _, level = pooled
    assert level == pytest.approx(0.4 * N / (1.0 + N), abs=0.2 * DX)
    fields, wet = simulation.particles, phases(simulation)
    x, z = fields["position"].T
    assert z[~wet].max() > 0.38 and x[~wet].max() < 0.4  # the soil stands
    outside = wet & (x > 0.45)
    np.testing.assert_allclose(fields["porosity"][outside & (x > 0.55)], 1.0, atol=0.02)


def test_water_in_the_soil_fills_its_pores(pooled):
    """After 3000 steps, in which particles crowd by a tenth if nothing parts them."""
    simulation, _, _ = pooled
    fields, wet = simulation.particles, phases(simulation)
    inside = wet & (fields["position"][:, 0] < 0.3)
    assert fields["porosity"][inside].mean() == pytest.approx(N, abs=0.05 * N)


def test_a_resumed_run_is_the_same_to_the_bit(tmp_path):
    whole = run_to(in_tub(*TUB, gravity=9.81), 0.03)
    assert_goes_on_alike(whole, 0.06, tmp_path)
