"""The kernels as a GPU runs them, one particle a thread: packs of one lane, here on the CPU."""

import numpy as np
import pytest

from snowmpm.errors import SimulationError
from snowmpm.sph.neighbours import NeighbourLists
from snowmpm.study.problems.particle_states import ParticleStates
from snowmpm.study.problems.schemes import lattice
from tests.support.sph_block import ICE, jittered, solver_of


def test_packs_of_one_lane_give_the_same_motion():
    positions, volumes = lattice([0.0, 0.0], [1.0, 0.6], 0.1, 1)
    places = []
    for width in (None, 1):
        solver = solver_of(jittered(positions, 0.1, 0.1), volumes, ICE, dx=0.1, gravity=[0.0, -9.81],
                           velocity=lambda x: np.stack([np.sin(3.0 * x[:, 1]), -2.0 + 0.0 * x[:, 0]], axis=1),
                           lower=[-1.0, 0.0], upper=[2.0, 2.0], width=width,
                           sides=[["slip", "open"], ["separate", "open"]])
        states = ParticleStates(solver)
        for _ in range(60):
            solver.step(1e-4)
        places.append((states.positions(), states.column("stress"), solver.impulse))
    for one, other in zip(*places, strict=True):
        assert np.abs(one - other).max() < 1e-9 * np.abs(one).max()


def test_lists_too_long_for_an_index_are_refused():
    with pytest.raises(SimulationError, match=r"need 2,304,000,000 entries; 2,147,483,647 at most.*solver\.dx"):
        NeighbourLists(3, "f32", 1)._reserve(9_000_000)
