"""A cantilever by steps at rest (I4): the elastica under its own weight and under a load at its end, in plane strain.

L / t = 20, six cells through the thickness, nu = 0, in one step from the straight beam. Beside these, a beam of
L / t = 8 that others have computed: L 8 m, H 1 m, rho 1000 kg/m3, E 90 MPa, nu 0: -0.67433 m (Kratos-Examples).
"""

import numpy as np
import pytest

from snowmpm.materials import Elastic
from snowmpm.study.problems.particle_states import ParticleStates
from snowmpm.study.problems.schemes import lattice
from tests.support.implicit_steps import implicit


def tip(law, length, thickness, gravity=0.0, end_load=0.0, cells=6, **solver):
    """Mean way of the end's particles (2,) [m], of a beam that a side holds on a node."""
    dx = thickness / cells
    x, volumes = lattice([0.0, 0.0], [length, thickness], dx)
    x = x + np.array([0.0, 1.5 * length - 0.5 * thickness])
    beam = implicit(x, volumes, law, dx, upper=[1.5 * length, 2.5 * length], gravity=[0.0, -gravity],
                    sides=[["stick", "open"], ["open", "open"]], time="quasi_static", solver=solver)
    states = ParticleStates(beam)
    end = np.abs(states.reference[:, 0] - states.reference[:, 0].max()) < 1e-9
    if end_load:
        gain = np.zeros_like(x)
        gain[end, 1] = -end_load / states.mass[end].sum()
        states.add(velocity=gain)  # over a step of 1 s
    beam.step(1.0)
    return (states.positions() - states.reference)[end].mean(axis=0)


RUBBER = Elastic(density=1000.0, youngs_modulus=1e6, poisson_ratio=0.0)
BENDING = 1e6 * 0.05**3 / 12.0


@pytest.mark.parametrize(("load", "down", "inward"), [
    (1.0, 0.123471, 0.008754), (5.0, 0.495905, 0.153343),
    pytest.param(20.0, 0.829881, 0.554768, marks=pytest.mark.slow)])
def test_own_weight(load, down, inward):
    found = tip(RUBBER, 1.0, 0.05, gravity=load * BENDING / (1000.0 * 0.05))
    assert -found[1] == pytest.approx(down, rel=0.01)
    assert -found[0] == pytest.approx(inward, rel=0.02)


@pytest.mark.parametrize(("load", "down", "inward"), [
    (1.0, 0.301721, 0.056433), pytest.param(3.0, 0.603253, 0.254420, marks=pytest.mark.slow),
    pytest.param(10.0, 0.810609, 0.554996, marks=pytest.mark.slow)])
def test_load_at_the_end(load, down, inward):
    found = tip(RUBBER, 1.0, 0.05, end_load=load * BENDING)
    assert -found[1] == pytest.approx(down, rel=0.01)
    assert -found[0] == pytest.approx(inward, rel=0.02)


def test_beam_of_others():
    law = Elastic(density=1000.0, youngs_modulus=90e6, poisson_ratio=0.0)
    assert tip(law, 8.0, 1.0, gravity=9.81)[1] == pytest.approx(-0.67433, rel=0.005)
