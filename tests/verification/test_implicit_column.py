"""Columns by implicit steps: under their own weight (M5, case I3), and under a load on top (case I5).

I3: exact with Lambert's W (`study.problems.self_weight_column`), in one step from the unstrained state. I5: a column
between smooth walls under a dead load p, nu = 0. Settlement over height, p / E = 0.01, 0.1, 0.2:

    Hencky                       ln F / F = -p / E                                0.00985, 0.0872, 0.1554
    neo-Hookean                  (F^2 - 1) (F^(-2/3) / 3 + 1/6) / F = -p / E       0.00991, 0.0912, 0.1673
    St. Venant and Kirchhoff's   (F^3 - F) / 2 = -p / E                            0.1211 at 0.1

The load is the weight of a heavy, weightless-otherwise row of particles on top, so the strain is measured below it.
"""

import numpy as np
import pytest

from snowmpm.materials import Elastic, NeoHookean, StVenantKirchhoff
from snowmpm.study.problems.particle_states import ParticleStates
from snowmpm.study.problems.schemes import lattice
from snowmpm.study.problems.self_weight_column import SNOW, SOFT, G, exact_height
from tests.support.implicit_steps import implicit

SIDES = [["slip", "slip"], ["stick", "open"]]


def hung(law, length, steps, **solver):
    """Errors of heights over the settlement, of sigma_yy over the largest pressure, and iterations of each step."""
    dx = length / 32
    x, volumes = lattice([0.0, 0.0], [dx, length], dx)
    column = implicit(x, volumes, law, dx, upper=[dx, 1.1 * length], sides=SIDES, time="quasi_static", solver=solver)
    states, iterations = ParticleStates(column), []
    for k in range(steps):
        column.set_gravity([0.0, -G * (k + 1) / steps])
        column.step(1.0)
        iterations.append(column.passed.iterations)
        assert column.passed.parts == 1
    Y = states.reference[:, 1]
    height = (states.positions()[:, 1] - exact_height(law, length, Y)) / (length - exact_height(law, length, length))
    pressure = law.density * G * (length - Y)
    tau = states.column("stress") / states.column("volume_ratio")
    return height, (tau[:, 1] + pressure) / pressure.max(), iterations


@pytest.mark.parametrize(("law", "gradient"), [(SOFT, "shape"), (SOFT, "affine"), (SNOW, "shape")])
def test_own_weight_in_one_step(law, gradient):
    height, stress, iterations = hung(law, 10.0, 1, gradient=gradient)
    assert np.abs(height).max() < 0.001
    assert np.abs(stress).max() < 0.02 and iterations[0] <= 8


@pytest.mark.parametrize("steps", [1, 10])
def test_half_of_its_height_in_at_most_ten_steps(steps):
    """L = 50 m: the foot is pressed to a quarter, and particles cross many cells."""
    height, stress, _ = hung(SOFT, 50.0, steps)
    assert np.abs(height).max() < 0.001
    assert np.sqrt((stress**2).mean()) < 0.02


@pytest.mark.parametrize(("kind", "load", "settlement"), [
    (Elastic, 1e5, 0.00985), (Elastic, 1e6, 0.0872), (Elastic, 2e6, 0.1554), (NeoHookean, 1e6, 0.0912),
    pytest.param(NeoHookean, 1e5, 0.00991, marks=pytest.mark.slow),
    pytest.param(NeoHookean, 2e6, 0.1673, marks=pytest.mark.slow),
    pytest.param(StVenantKirchhoff, 1e6, 0.1211, marks=pytest.mark.slow)])
def test_load_on_top(kind, load, settlement):
    law = kind(density=1e-3, youngs_modulus=1e7, poisson_ratio=0.0)
    dx = 1.0 / 16.0
    x, volumes = lattice([0.0, 0.0], [dx, 1.0 + dx], dx)
    heavy = x[:, 1] > 1.0
    weight = law.model_copy(update={"density": load / (9.81 * dx)})
    column = implicit(x, volumes, [law, weight], dx, upper=[dx, 1.5], sides=SIDES, gravity=[0.0, -9.81],
                      material=heavy.astype(int), time="quasi_static")
    states = ParticleStates(column)
    column.step(1.0)
    below = states.reference[:, 1] < 0.8
    strain = 1.0 - np.polyfit(states.reference[below, 1], states.positions()[below, 1], 1)[0]
    assert strain == pytest.approx(settlement, abs=6e-5)  # of its last digit, and of the smear of the load
    deep = states.reference[:, 1] < 0.6
    np.testing.assert_allclose(states.column("stress")[deep, 1] / states.column("volume_ratio")[deep, 0], -load,
                               rtol=0.01)  # half of what M5 asks for; seen: 0.3 %
