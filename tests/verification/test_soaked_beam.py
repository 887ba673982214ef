"""A saturated cantilever (P4): suction above, pressure below, and it sinks on while they equalise."""

import pytest

from snowmpm.study.problems.soaked_beam import deflection, pressures, soaked_beam


def sunk(times, **choices):
    """Deflections [m] at the times [s]; the water's budget closes."""
    simulation, found = soaked_beam(**choices), []
    for time in times:
        while simulation.time < time - 1e-12:
            simulation.step(until=time)
        found.append(deflection(simulation))
        assert simulation.audit()["water_residual"] < 1e-10
    return simulation, found


def test_before_water_moves():
    """Undrained, twice as stiff in the plane: 0.15 to 0.17 m, with suction where it is stretched."""
    simulation, (tip,) = sunk((1e-5,))
    above, below = pressures(simulation)
    assert 0.15 < tip < 0.17
    assert above < -2e5 and below > 2e5


@pytest.mark.slow
def test_once_pressures_are_equal_across():
    """0.28 to 0.30 m at 0.6 s; pressures have fallen to a tenth."""
    simulation, tips = sunk((0.06, 0.2, 0.6), dt=0.02, ramp=0.06)
    above, below = pressures(simulation)
    assert 0.28 < tips[-1] < 0.30 and tips[0] < tips[1] < tips[2]
    assert abs(below - above) < 0.1 * 5e5


@pytest.mark.slow
def test_finer():
    _, (tip,) = sunk((1e-5,), dx=0.025)
    _, tips = sunk((0.6,), dx=0.025, dt=0.02, ramp=0.06)
    assert 0.15 < tip < 0.17 and 0.28 < tips[-1] < 0.305


@pytest.mark.slow
def test_a_load_on_top_bends_it_more():
    """It moves outwards as the beam turns."""
    _, (tip,) = sunk((1e-5,), on="top")
    assert 0.165 < tip < 0.18
