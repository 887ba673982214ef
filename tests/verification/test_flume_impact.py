"""Sand that runs down a flume against a wall (G5), by MPM and by SPH: the force on the wall.

From the run file alone: what bed, wall and weight gave is the momentum that the sand has; the force at rest lies
between Coulomb's wedges over the heap that the run leaves (`snowmpm.comparison.answers.wall_thrust`); what the flow has
given the wall while it arrives does not depend on the resolution.

The force at rest does. The bed alone cannot hold the sand (45 degrees, friction 0.5), so the wall bears the weight
along the bed, 1440 N/m, and the friction of the bed, anywhere between -720 and 720 N/m; the jet that falls back from
the wall spreads the heap up the bed, and the finer the grid the higher the jet. MPM at 0.025, 0.0125, 0.00625 m:

    friction of the bed 94, 290, 468 N/m up;  thrust at rest 1531, 1722, 1902;  largest force 1655, 1835, 1984
    impulse on the wall after 1 s  608, 624, 644 N s/m

By SPH at 0.025, 0.0125 m: 1392, 1540; 1685, 1770; 578, 588.
"""

import numpy as np
import pytest

import snowmpm
from snowmpm.comparison import Case
from snowmpm.comparison.answers import answer_of
from snowmpm.scenes import load_scene

SOFT = 5.4e5
"""Young's modulus [Pa] of the sand here: a fortieth of the published one, under which the heap settles by 1 %."""

ARRIVED = 1.0
"""Time [s] at which most of the flow has reached the wall, and nothing slides back yet."""

WINDOW = 0.1
"""Time [s] over which the largest force is a mean: single grains that arrive are no force of the flow."""


def impact(folder, method, spacing):
    """Answer of a run with particles at this distance [m]."""
    changes = {"solver.method": method, "solver.dx": spacing if method == "sph" else 2.0 * spacing, "end_time": 2.0,
               "materials.sand.youngs_modulus": SOFT}
    return answer_of(Case(method, snowmpm.run(load_scene("flume_impact", changes), folder)))


def largest_force(answer):
    wall = answer.case.run.obstacles["wall"]
    time = np.arange(0.0, wall.time[-1] - WINDOW, 0.01)
    impulse = np.interp(time + WINDOW, wall.time, wall.impulse[:, 0]) - np.interp(time, wall.time, wall.impulse[:, 0])
    return float(impulse.max() / WINDOW)


@pytest.mark.parametrize("method", ["mpm", pytest.param("sph", marks=pytest.mark.slow)])
def test_force_on_the_wall(method, tmp_path):
    answer = impact(tmp_path, method, 0.025)
    assert abs(answer.momentum_gap()) < 0.03
    low, high = answer.bounds()
    assert low < answer.thrust() < high
    # All of it is there, behind the wall, and at rest
    history = answer.case.run.history
    assert history["mass"][-1] == history["mass"][0]
    assert history["kinetic_energy"][-1] < 1e-3 * history["kinetic_energy"].max()


def impulse(answer):
    """That the wall has taken when most of the flow has arrived [N s/m]."""
    wall = answer.case.run.obstacles["wall"]
    return float(np.interp(ARRIVED, wall.time, wall.impulse[:, 0]))


@pytest.fixture(scope="module")
def fine(tmp_path_factory):
    """Answers of a method at two spacings, the published 10 and 5 mm a little finer; run once."""
    found = {}

    def of(method):
        if method not in found:
            folder = tmp_path_factory.mktemp(method)
            found[method] = [impact(folder / str(n), method, 0.3 / n) for n in (36, 72)]
        return found[method]

    return of


@pytest.mark.slow
@pytest.mark.parametrize("method", ["mpm", "sph"])
def test_half_the_spacing(method, fine):
    coarse, half = fine(method)
    assert abs(half.momentum_gap()) < 0.03
    low, high = half.bounds()
    assert low < half.thrust() < high
    assert impulse(half) == pytest.approx(impulse(coarse), rel=0.05)
    assert largest_force(half) == pytest.approx(largest_force(coarse), rel=0.05)
    assert half.thrust() == pytest.approx(coarse.thrust(), rel=0.05)


@pytest.mark.slow
def test_both_methods_find_the_same_force(fine):
    mpm, sph = (fine(method)[1] for method in ("mpm", "sph"))
    assert impulse(sph) == pytest.approx(impulse(mpm), rel=0.1)
    assert largest_force(sph) == pytest.approx(largest_force(mpm), rel=0.1)
    assert sph.thrust() == pytest.approx(mpm.thrust(), rel=0.1)
