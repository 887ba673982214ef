"""Frameworks that go straight to rest: published bends, closed forms, the rest of damped motion, what has none."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from snowmpm.components.structures.framework import BEYOND, Framework
from snowmpm.components.structures.framework_mesh import Member
from snowmpm.components.structures.framework_motion import BREAKING
from snowmpm.components.structures.framework_rest import bring_to_rest
from snowmpm.components.structures.section import Section
from snowmpm.errors import SimulationError
from tests.components.structures.frameworks import HEIGHT, WIDTH, moved, portal, pushed

BAR = {"modulus": 2.1e11, "density": 7850.0}


def at_rest(one, loads):
    forces = np.zeros_like(one.x)
    for name, force in loads.items():
        forces[one.mesh.joints[name]] = force
    bring_to_rest(one, forces)
    return one


def test_a_large_load_bends_a_bar_as_the_elastica():
    """E I theta'' = -P cos(theta) with P L^2 = 4 E I, by shooting: with 1 / n^2."""
    def shot(curvature):
        return solve_ivp(lambda s, y: [y[1], -4.0 * np.cos(y[0]), np.sin(y[0]), np.cos(y[0])], [0.0, 1.0],
                         [0.0, curvature, 0.0, 0.0], rtol=1e-10, atol=1e-10).y[:, -1]

    exact, errors = shot(brentq(lambda curvature: shot(curvature)[1], 0.1, 6.0)), []
    for n in (4, 8, 16):
        one = Framework({"a": (0.0, 0.0, 0.0), "b": (0.0, 0.0, 1.0)}, {"a": "fixed"},
                        [Member("a", "b", Section(1e6, 1.0, 1.0), n)], plane=True)
        tip = at_rest(one, {"b": [4.0, 0.0, 0.0]}).x[one.mesh.joints["b"]][[0, 2]]
        errors.append(np.linalg.norm(tip - exact[2:]))
    assert errors[1] < 2e-3
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.1) and errors[1] / errors[2] == pytest.approx(4.0, rel=0.1)


def test_a_bend_of_45_degrees_leaves_its_plane_as_published():
    """K.-J. Bathe and S. Bolourchi (1979), doi:10.1002/nme.1620140703, as in `test_frameworks`."""
    angles = np.radians(45.0) * np.arange(9) / 8
    joints = {f"j{i}": (100.0 * np.sin(a), 100.0 * (1.0 - np.cos(a)), 0.0) for i, a in enumerate(angles)}
    one = Framework(joints, {"j0": "fixed"}, [Member(f"j{i}", f"j{i + 1}", Section(1e7, 1e7 / 12.0, 1.0), 1)
                                              for i in range(8)], poisson_ratio=0.0)
    tip = moved(at_rest(one, {"j8": [0.0, 0.0, 600.0]}), "j8")
    assert tip[2] == pytest.approx(53.4, abs=0.5)
    assert tip[:2] == pytest.approx([-23.5, -13.4], abs=0.5)


@pytest.mark.parametrize("plane", [True, False])
def test_rest_is_where_damped_motion_ends(plane):
    """A portal with a pinned end under loads that bend it far, in the plane and out of it."""
    loads = {"b": [8000.0, 0.0 if plane else 900.0, -2000.0], "c": [0.0, 0.0, -3000.0]}
    one, other = (portal(segments=4, plane=plane, pinned=[("b-c", "c")]) for _ in range(2))
    pushed(one, loads, periods=12.0)
    at_rest(other, loads)
    assert np.linalg.norm(moved(one, "b")) > 0.06 * HEIGHT
    assert np.allclose(one.x, other.x, atol=1e-9 * HEIGHT)
    assert np.allclose(one.moments, other.moments, atol=1e-8 * np.abs(one.moments).max())
    assert not other.v.any() and other.energy > 0.0


@pytest.mark.parametrize(("share", "holds"), [(0.99, True), (1.01, False)])
def test_a_portal_bears_its_plastic_limit_load(share, holds):
    """P = 4 M_p / h, as in `test_frameworks_that_give_way`: rest up to one per cent below it, and none beyond."""
    section = Section.tube(WIDTH, 0.5 * WIDTH, *BAR.values(), yield_stress=2.35e6)
    one, load = portal(section=section, segments=1), {"b": [share * 4.0 * section.yield_moment / HEIGHT, 0.0, 0.0]}
    if not holds:
        with pytest.raises(SimulationError, match=r"finds no rest beyond 0\.99"):
            at_rest(one, load)
        return
    at_rest(one, load)
    assert np.count_nonzero(one.plastic.any(axis=2)) == 2  # both feet, and the corners nearly
    assert np.linalg.norm(one.moments, axis=2).max() <= section.yield_moment * (1.0 + 1e-6)


def test_an_end_that_breaks_hands_its_load_on():
    """A portal with a flaw at one foot: it stands on as one with that foot pinned. A post alone falls."""
    weak, load = Section.tube(WIDTH, 0.5 * WIDTH, *BAR.values(), strength=1e8), {"b": [60.0, 0.0, 0.0]}
    one, other = portal(section=weak), portal(pinned=[("a-b", "a")])
    one._elements[0, BREAKING] = 1.0 / 30.0  # of what its foot would have to bear, less than half
    at_rest(one, load)
    assert one.broken[0, 0] and np.count_nonzero(one.broken) == 1
    assert np.allclose(one.x, at_rest(other, load).x, atol=1e-7 * HEIGHT)
    post = Framework({"a": (0.0, 0.0, 0.0), "b": (0.0, 0.0, 1.0)}, {"a": "fixed"}, [Member("a", "b", weak, 2)])
    with pytest.raises(SimulationError, match=r"finds no rest beyond 0\.(49|5).* 1 ends broken"):
        at_rest(post, {"b": [2.0 * weak.breaking_moment, 0.0, 0.0]})
    assert post.largest_moment <= weak.breaking_moment * (1.0 + BEYOND)


def test_a_state_goes_on_to_the_bit():
    """From one rest, where it yields, to the next."""
    section = Section.tube(WIDTH, 0.5 * WIDTH, *BAR.values(), yield_stress=8e7, hardening=1.0, strength=2e8)
    one, other = (portal(section=section) for _ in range(2))
    at_rest(one, {"b": [3800.0, 0.0, -300.0]})
    other.restore(one.state())
    assert other.plastic.any() and other.plastic_work > 0.0
    for each in (one, other):
        at_rest(each, {"b": [4300.0, 0.0, -300.0]})
    for name, table in one.state().items():
        assert table.tobytes() == other.state()[name].tobytes()
