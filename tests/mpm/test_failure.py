"""A step that cannot be right says so."""

import numpy as np
import pytest

from snowmpm.errors import SimulationError


def test_a_particle_that_is_not_finite_is_named(make_solver):
    solver = make_solver(2, 0.1, [0.0, 0.0], [0.4, 0.4])
    table = solver.particles.table()
    table[17, solver.particles.layout.columns("velocity")] = np.nan
    place, numbers = solver.particles.positions(), solver.particles.labels()[:, 1]
    solver.particles.overwrite(table)
    with pytest.raises(SimulationError, match="particle") as error:
        solver.step(1e-4)
    assert "t = 0" in str(error.value) and "near" in str(error.value)
    named = place[numbers == int(str(error.value).split()[1])]
    # The grid hands NaN on to every particle that shares a node: fewer than three cells away along an axis.
    assert len(named) == 1 and np.abs(named[0] - place[17]).max() < 3 * 0.1


def test_an_unstable_step_fails_loudly_not_silently(make_solver):
    solver = make_solver(2, 0.1, [0.0, 0.0], [0.6, 0.6], velocity=lambda x: np.array([0.1 * x[1], 0.2 * x[0]]))
    dt = 4.0 * solver.critical_dt()[0]
    with pytest.raises(SimulationError, match="no longer finite"):
        for _ in range(2000):
            solver.step(dt)
