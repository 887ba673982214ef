"""Newton's method (I1): the residual falls with its square, of elastic and of yielding steps."""

import numpy as np
import pytest

from snowmpm.errors import SimulationError
from snowmpm.materials import CohesiveCamClay, Elastic, VonMises
from snowmpm.study.problems.schemes import lattice
from tests.support.implicit_steps import implicit

SNOW = {"density": 250.0, "youngs_modulus": 1e6, "poisson_ratio": 0.3}
LAWS = {
    "elastic": Elastic(**SNOW),
    "von Mises": VonMises(**SNOW, yield_stress=1.5e3, hardening_modulus=5e5),
    "Cam-Clay": CohesiveCamClay(**SNOW, critical_slope=1.2, cohesion=0.3, hardening=1.0, p0=2.5e3),
}


def block(law, gravity, *, sides=(("stick", "open"), ("stick", "open")), **options):
    """A block of 6 x 6 cells in the corner of two sides, at rest."""
    x, volumes = lattice([0.0, 0.0], [1.5, 1.5], 0.25)
    return implicit(x, volumes, law, 0.25, upper=[4.0, 4.0], gravity=gravity, sides=[list(one) for one in sides],
                    time="quasi_static", **options)


@pytest.mark.parametrize("name", LAWS)
def test_residuals_fall_with_their_square(name):
    solver = block(LAWS[name], [-6.0, -9.81])
    solver.step(1.0)
    r = np.array(solver.passed.residuals)
    assert solver.passed.parts == 1 and (solver.n_plastic > 10) == (name != "elastic")
    last = np.flatnonzero((r[:-1] < 1e-2) & (r[1:] > 1e-13))
    assert len(last) >= 1
    # What a step leaves is at most the square of what it found, times a number of the order of stiffness over strength
    assert (r[last + 1] / r[last] ** 2 < 300.0).all(), r
    assert r[-1] <= 1e-9


@pytest.mark.parametrize("name", LAWS)
def test_iterations_solve_the_same_equations(name):
    found = []
    for linear in ("direct", "krylov"):
        solver = block(LAWS[name], [-6.0, -9.81], linear=linear)
        solver.step(1.0)
        found.append(solver.particles.positions())
    np.testing.assert_allclose(*found, rtol=0, atol=1e-8)


def test_what_nothing_holds_is_said():
    """A free block under its weight has no rest: two lines that say so, and where."""
    solver = block(LAWS["elastic"], [0.0, -9.81], sides=(("open", "open"), ("open", "open")), iterations=3)
    with pytest.raises(SimulationError) as failed:
        solver.step(1.0)
    assert "not solved" in str(failed.value) and "nothing holds" in str(failed.value)
    assert len(str(failed.value).splitlines()) == 2


def test_a_load_is_applied_in_parts_where_it_cannot_be_at_once():
    """Soft rubber that hangs by its side."""
    rubber = Elastic(density=1000.0, youngs_modulus=2e5, poisson_ratio=0.3)
    solver = block(rubber, [0.0, -9.81], sides=(("stick", "open"), ("open", "open")), iterations=3)
    solver.step(1.0)
    whole = block(rubber, [0.0, -9.81], sides=(("stick", "open"), ("open", "open")))
    whole.step(1.0)
    assert solver.passed.parts > 1 == whole.passed.parts
    np.testing.assert_allclose(solver.particles.positions()[:, 1].mean(), whole.particles.positions()[:, 1].mean(),
                               atol=0.01)


def test_surfaces_bear_the_weight():
    solver = block(LAWS["von Mises"], [2.0, -9.81])
    solver.step(0.5)
    weight = 250.0 * 1.5**2 * np.array([2.0, -9.81])
    np.testing.assert_allclose(solver.totals.impulse, -0.5 * weight, rtol=1e-8)
    np.testing.assert_allclose(solver.totals.weight_impulse, 0.5 * weight, rtol=1e-12)
