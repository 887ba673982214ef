"""Terzaghi's column (P1): pore water carries the load at first, and leaves through the top."""

import numpy as np
import pytest

from snowmpm.running.simulation import Simulation
from tests.support.soaked_column import C_V, consolidation, pressure_error, settlement
from tests.support.soaked_column import column as scene_of
from tests.support.water_masses import assert_masses_close, audited


def consolidating(times, dx=0.025, **changes):
    """(particles, row of the audit) at each of these times [s]."""
    simulation, found = Simulation(scene_of(dx, **changes)), []
    for time in times:
        while simulation.time < time:
            simulation.step(until=time)
        found.append((simulation.particles, simulation.audit()))
    return simulation, found


@pytest.fixture(scope="module")
def usual():
    """Of the step that the program chooses, 2.8e-4 s, at t = 0.02 and 0.1 s."""
    return consolidating((0.02, 0.1))


@pytest.fixture(scope="module")
def short():
    """Of steps of 1e-4 s, at the same times."""
    return consolidating((0.02, 0.1), solver={"dt": 1e-4})


def test_pressures(usual):
    """Twice the errors of a quasi-static implicit program at 1e-3 s are the gates: 0.0079 and 0.0015."""
    simulation, found = usual
    assert simulation.dt < 1e-3
    errors = [pressure_error(particles, C_V * t) for (particles, _), t in zip(found, (0.02, 0.1), strict=True)]
    assert errors[0] < 2.0 * 0.0079 and errors[1] < 2.0 * 0.0015


@pytest.mark.xfail(strict=True, reason="0.0043 and 0.0008: the column has inertia, and its pressure is a step late")
def test_pressures_of_short_steps(short):
    """Twice the errors of that program at 1e-4 s: 0.0017 and 0.0003."""
    _, found = short
    errors = [pressure_error(particles, C_V * t) for (particles, _), t in zip(found, (0.02, 0.1), strict=True)]
    assert errors[0] < 2.0 * 0.0017 and errors[1] < 2.0 * 0.0003


def test_settlement_follows_the_water(usual):
    """1.000 mm U, to 1 % of it; the water that left is the volume that the column lost, less its own expansion."""
    _, found = usual
    for (particles, row), t in zip(found, (0.02, 0.1), strict=True):
        sunk = settlement(particles)
        assert sunk == pytest.approx(1e-3 * consolidation(C_V * t), rel=0.01)
        swollen = 0.4 / 2.2e9 * (1e4 - particles["pore_pressure"].mean())
        assert row["drained_water"] == pytest.approx(1000.0 * 0.1 * (sunk + swollen), rel=2e-3)


def test_budgets(usual):
    _, found = usual
    for particles, row in found:
        assert row["water_residual"] < 1e-12 and row["momentum_residual"] < 1e-10
        assert row["mass"] - row["water_mass"] == pytest.approx(1600.0 * 0.1, rel=1e-13)
        # A pressure acts a step late
        assert abs(row["energy_remainder"]) < 0.03 * abs(row["water_work"])
        np.testing.assert_allclose(particles["porosity"], 1.0 - 0.6 / particles["J"], rtol=1e-13)
        np.testing.assert_allclose(particles["saturation"], 1.0, atol=1e-5)  # p / K_w


@pytest.mark.parametrize("split", ["semi_implicit", "explicit"])
def test_masses_in_every_audit(split):
    """Of snow and of water, while water drains."""
    rows = audited(Simulation(scene_of(0.1, water={"split": split, "bulk_modulus": 2.2e8})), 0.01)
    assert assert_masses_close(rows) > 10 and rows[-1]["drained_water"] > 0.0


def test_coarse_column():
    """10 cells: twice 0.0045."""
    _, found = consolidating((0.1,), dx=0.1)
    assert pressure_error(found[0][0], C_V * 0.1, 0.1) < 2.0 * 0.0045


def test_sealed_column():
    """Nothing drains: the water keeps carrying the load, and the column stands."""
    _, found = consolidating((0.02,), dx=0.1, water={"surface": "sealed"})
    particles, row = found[0]
    np.testing.assert_allclose(particles["pore_pressure"], 1e4, rtol=2e-3)
    assert abs(settlement(particles)) < 1e-6 and row["drained_water"] == 0.0
    assert row["max_speed"] < 1e-4


def test_a_border_begins_to_drain():
    """Sealed for 0.02 s; from then on the column consolidates as it does from the start."""
    event = {"kind": "drainage", "border": "surface", "becomes": "drained", "start": 0.02}
    _, found = consolidating((0.02, 0.12), dx=0.1, water={"surface": "sealed"}, events=[event])
    assert found[0][1]["drained_water"] == 0.0
    assert pressure_error(found[1][0], C_V * 0.1, 0.1) < 2.0 * 0.0045


@pytest.mark.parametrize("permeability", [1e-18, 1e-5])
def test_steps_do_not_hang_on_permeability(permeability):
    """From clay to gravel the step is that of the drained skeleton, and what a jolt left stays bounded."""
    simulation, found = consolidating((0.02,), dx=0.1, water={"permeability": permeability})
    assert simulation.solver.stable_dt()[0] == pytest.approx(consolidating((0.0,), dx=0.1)[0].solver.stable_dt()[0],
                                                             rel=0.05)
    particles, row = found[0]
    assert row["max_speed"] < 0.2 and row["energy_remainder"] > -1e-6
    if permeability < 1e-9:
        np.testing.assert_allclose(particles["pore_pressure"], 1e4, rtol=0.05)
    else:
        assert particles["pore_pressure"].max() < 6e3


def test_the_explicit_split_follows_undrained_waves():
    """Its step is shorter by the ratio of the wave speeds, and it gives the same pressures."""
    usual = consolidating((0.0,), dx=0.1)[0].solver
    simulation, found = consolidating((0.02,), dx=0.1, water={"split": "explicit", "bulk_modulus": 2.2e8})
    ratio = usual.stable_dt()[0] / simulation.solver.stable_dt()[0]
    # A grain swells along both axes: 2 K_w / n beside E / rho
    assert ratio == pytest.approx(np.sqrt(1.0 + 2.0 * 2.2e8 / 0.4 / 2000.0 / (1e7 / 1600.0)), rel=0.02)
    assert found[0][1]["water_residual"] < 1e-13
    assert pressure_error(found[0][0], C_V * 0.02, 0.1) < 0.05


@pytest.mark.slow
def test_whole_consolidation():
    """To T = 1, against the table of the case."""
    times = np.array([0.2, 0.5, 1.0]) / C_V
    _, found = consolidating(times, dx=0.05)
    for (particles, row), T in zip(found, (0.2, 0.5, 1.0), strict=True):
        assert pressure_error(particles, T, 0.05) < 2.0 * 0.0015
        assert settlement(particles) == pytest.approx(1e-3 * consolidation(T), rel=0.02)
        assert row["water_residual"] < 1e-12


@pytest.mark.slow
def test_in_space():
    """The same column in 3-D gives the same pressures."""
    flat, solid = (consolidating((0.02,), dx=0.1, dimension=dimension)[1][0][0] for dimension in (2, 3))
    found = [np.sort(particles["pore_pressure"])[:: len(particles["id"]) // 10] for particles in (flat, solid)]
    np.testing.assert_allclose(found[0], found[1], rtol=1e-3)
