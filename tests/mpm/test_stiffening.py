"""The time step follows laws whose stiffness changes."""

import numpy as np
import pytest

from snowmpm import Simulation
from snowmpm.scenes import material_card
from snowmpm.scenes.loader import load_scene


def limit_after(solver, column, value):
    """Largest stable step after all particles were given `value` in a column, and stepped once."""
    table = solver.particles.table()
    table[:, solver.particles.layout.columns(column)] = value
    solver.particles.overwrite(table)
    solver.step(1e-7)
    dt, cause = solver.stable_dt()
    assert cause == "elastic"
    return dt


def test_hardened_snow_shortens_the_step(make_solver):
    law = material_card("stomakhin")
    solver = make_solver(2, 0.1, [0.0, 0.0], [0.4, 0.4], law=law)
    soft, hard = (limit_after(solver, "state", ratio) for ratio in (1.0, 0.7))
    assert soft == pytest.approx(solver.cfl * 0.1 / law.wave_speed(), rel=0.04)  # the bound of its thresholds
    assert soft / hard == pytest.approx(np.exp(0.5 * law.hardening * 0.3), rel=1e-6)  # c² grows like the factor
    # torn snow is soft, but other snow beside it need not be
    assert limit_after(solver, "state", 1.5) == pytest.approx(solver.cfl * 0.1 / law.wave_speed(), rel=1e-6)


def test_pressure_above_the_reference_shortens_the_step(make_solver):
    law = material_card("peng_sand")
    solver = make_solver(2, 0.1, [0.0, 0.0], [0.4, 0.4], law=law)
    pressures = [limit_after(solver, "elastic", [-p, -p, -p, 0.0]) for p in (1e4, 4e5, 1.6e6)]
    c = law.wave_speed_at(-4e5 * np.array([[1.0, 1.0, 1.0, 0.0, 0.0, 0.0]]), np.array([law.initial_state()]))[0]
    assert pressures[0] > pressures[1]
    assert pressures[1] <= solver.cfl * 0.1 / c * (1.0 + 1e-6)  # the step of 1e-7 s changes the pressure by that little
    assert pressures[1] / pressures[2] == pytest.approx(2.0, rel=0.01)  # c grows like the root of the pressure


@pytest.mark.parametrize("pressure", [1e4, 4e5])
def test_first_step_follows_the_stress_of_the_start(make_solver, pressure):
    """A law that stores its stress took it for a strain: the first step was 1.8 times too short."""
    law = material_card("peng_sand")
    solver = make_solver(2, 0.1, [0.0, 0.0], [0.4, 0.4], law=law, stress=-pressure * np.eye(3))
    first = solver.stable_dt()[0]
    c = law.wave_speed_at(-pressure * np.array([[1.0, 1.0, 1.0, 0.0, 0.0, 0.0]]), np.array([law.initial_state()]))[0]
    assert first == pytest.approx(solver.cfl * 0.1 / max(c, law.wave_speed()), rel=1e-12)
    solver.step(1e-7)
    assert solver.stable_dt()[0] == pytest.approx(first, rel=0.01)


def test_first_step_of_a_hypoplastic_scene_with_initial_stress():
    simulation = Simulation(load_scene("oedometer"))
    solver, law = simulation.solver, simulation.model.laws[0]
    assert solver.particles.table()[:, solver.particles.layout.columns("elastic")].min() == -1e4
    dt, cause = solver.stable_dt()
    assert cause == "elastic" and dt == pytest.approx(solver.cfl * solver.dx / law.wave_speed(), rel=1e-12)
