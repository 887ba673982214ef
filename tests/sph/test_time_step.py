"""How long a step may be: free elastic blocks of disordered particles in random motion, at the critical C and above."""

import numpy as np
import pytest

from snowmpm.errors import SimulationError
from snowmpm.study.problems.schemes import lattice
from tests.support.sph_block import ICE, jittered, solver_of


def energy_left(cfl, steps=600, **scheme):
    """Kinetic energy after so many steps over that of the start; cfl: a number, or None for the critical one."""
    dx = 0.1
    positions, volumes = lattice([0.0, 0.0], [1.6, 1.6], dx, 1)
    velocities = np.random.default_rng(0).normal(0.0, 1e-3, positions.shape)
    solver = solver_of(jittered(positions, dx, 0.2), volumes, dx=dx, velocity=lambda x: velocities, scheme=scheme)
    dt = (cfl or solver.critical_cfl) * dx / ICE.wave_speed()
    for _ in range(steps):
        solver.step(dt)
    return float((solver.particles.column("velocity") ** 2).sum() / (velocities**2).sum())


@pytest.mark.parametrize("scheme", [{}, {"viscosity": 1.0}, {"disorder_damping": 2.0}], ids=str)
def test_the_critical_step_is_stable(scheme):
    assert energy_left(None, **scheme) < 0.02


def test_steps_beyond_it_are_not():
    with pytest.raises(SimulationError):
        energy_left(0.6, disorder_damping=2.0)
    with pytest.raises(SimulationError):
        energy_left(1.4)


@pytest.mark.parametrize("balance", [{}, {"momentum": "corrected"}], ids=str)
def test_a_gradient_out_of_balance_with_the_forces_makes_energy(balance):
    """Of an undamped, disordered block: corrected gradient, plain sum of forces."""
    bare = {"viscosity": 0.0, "disorder_damping": 0.0}
    assert energy_left(0.3, **bare, **balance) < 1.0 < energy_left(0.3, gradient="corrected", **bare)
