"""initial.relaxation = "static" (I8): the balance that damped steps tend to, from which a run begins and is still."""

import numpy as np
import pytest

from snowmpm.errors import InputError
from snowmpm.running.simulation import Simulation
from snowmpm.scenes import load_scene

SMALL = {"solver.dx": 0.05, "saw_test.length": 1.5, "saw_test.slope_angle": 25.0, "solver.precision": "f64"}


def simulation(relaxation, name="pst_2d", **overrides):
    return Simulation(load_scene(name, {**SMALL, "initial.relaxation": relaxation, **overrides}))


def stresses(one):
    solver = one.solver.particles
    return solver.column("stress")[np.argsort(solver.labels()[:, 1])]


def largest_speed(one, steps):
    """Over sqrt(g D), D 0.55 m."""
    found = 0.0
    for _ in range(steps):
        one.step()
        found = max(found, one.max_speed)
    return found / np.sqrt(9.81 * 0.55)


@pytest.fixture(scope="module")
def static():
    return simulation("static")


SLOWLY = pytest.mark.xfail(strict=True, raises=AssertionError, reason="0.75 %: the slab's corners creep there")


@pytest.mark.slow
@pytest.mark.parametrize("tolerance", [pytest.param(2e-5, marks=SLOWLY), 2e-6])
def test_it_is_what_damped_steps_tend_to(static, tolerance):
    """The damped ones to a small tolerance: their stress then differs by what they have yet to move.

    Seen at 2e-3, 2e-5 and 2e-6: 1.5, 0.75 and 0.14 %.
    """
    exact = stresses(static)
    off = []
    for allowed in (2e-3, tolerance):
        found = stresses(simulation("damped", **{"initial.tolerance": allowed}))
        off.append(np.sqrt(((found - exact) ** 2).mean() / (exact**2).mean()))
    assert off[1] < 2e-3 and off[1] < 0.2 * off[0]


def test_a_run_begins_without_ringing(static):
    """The tolerance is 2e-3; half a transit of a wave through the column."""
    assert static.time == 0.0 and static.solver.particles.count > 0
    assert largest_speed(static, 40) < 1e-4


def test_where_it_cannot_damped_steps_do():
    """A block that may slide on the ground has no balance that a surface holds."""
    from tests.contract import method_examples as given

    scene = given.scene("mpm", gravity=9.81, terrain={"kind": "plane", "contact": "separate", "friction": 0.5},
                        bodies=[given.body(given.layer(2, 0.0, 0.6, 0.3))],
                        initial={"stress": "settle", "tolerance": 0.05, "relaxation": "static"})
    assert Simulation(scene).solver.totals.weight_impulse.any() == 0


def test_only_what_is_known_is_taken():
    with pytest.raises(InputError, match=r"initial\.relaxation"):
        load_scene("pst_2d", {"initial.relaxation": "magic"})
