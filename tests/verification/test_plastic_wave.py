"""A piston drives a compaction wave into snow (M10), exact: fronts of a rate-independent material in uniaxial strain.

Exact: `compaction_wave`, the upper concave hull of the oedometric path; its last, straight part is the shock.

dx = 0.01 m; what is measured: `piston`. The problem has no length of its own: 100 cells of way are
50 cells on a grid twice as fine, so what is off there after the start is off on any grid.

In fresh snow the front is three cells wide where nothing damps it, and rings. Of the fan of plastic waves that should
run ahead of it, those slower than 78 m/s do not come off (elastic waves that unload them, presumably): the shock
starts from 2790 Pa and 0.113 m/s instead of 3143 Pa and 0.148 m/s, and the jump conditions from there give the speed,
stress and density that are found. Errors of D, P1 and rho1 in per cent at 4.3 m/s, and what does not change them:

    APIC            -2.3  -4.2  +2.3      3 particles an axis -2.3 -4.2 +2.3, cubic -2.0 -4.2 +2.1, gradient "shape"
                                          -2.4 -4.3 +2.4, periodic across -2.3 -4.2 +2.3, piston started over 0.01 s
                                          -2.3 -4.2 +2.3, a quarter of the step -1.4 -4.3 +1.6
    the same with   -1.9  -3.6  +1.9      added to its stress where snow is compressed
    rho (dx div v)^2
    FLIP 0.99       -7.1  -5.0  +6.2      0.97 -3.6 -3.1 +2.4 (in a strip of two cells)
    FLIP 0.95       -1.4  -1.0  +1.0
    FLIP 0.90       -0.1  -0.4  -0.2
    PIC             +5.3  -1.8  -9.6      so wide a front that it is not all there yet

That is no fault of the grid: a row of finite elements of the same law, without one, is off by more where nothing damps
it (D -10, rho1 +9 %), and by 0.1 % with von Neumann's viscosity (`row_of_elements`). A law without rate gives its front
no width; what a scheme does in it decides the state that is left, and is kept for good by the plastic strain.

What FLIP damps in a step is the viscosity that a shock wants: 0.95, the least of the snow chapter, has enough of it.
"""

from dataclasses import replace

import numpy as np
import pytest

from snowmpm.study.problems.compaction_wave import front
from snowmpm.study.problems.piston import FIRM, FRESH, FRONTS, drive
from snowmpm.study.problems.schemes import APIC, FLIP, Scheme
from tests.verification import row_of_elements


@pytest.mark.parametrize(("kind", "speed"), FRONTS)
def test_the_exact_wave(kind, speed):
    exact = front({"firm": FIRM, "fresh": FRESH}[kind], speed)
    assert (exact.speed, exact.stress, exact.density) == pytest.approx(FRONTS[kind, speed], rel=5e-4)
    # In fresh snow a fan of plastic waves runs ahead of the shock: it yields at 1864 Pa
    assert exact.foot == pytest.approx({"firm": 34307.7, "fresh": 3145.0}[kind], rel=1e-3)


def errors_of_elements(linear, quadratic):
    """Shares by which the row misses D, P1 and rho1 of fresh snow at 4.3 m/s, and the ripple of its stress."""
    D, P, density = FRONTS["fresh", 4.3]
    time, way, stress, found = row_of_elements.drive(FRESH, 4.3, 2.0, 0.02, 0.8 / D, linear, quadratic)
    late, behind = way > 0.25, slice(8, 30)
    return (np.polyfit(time[late], way[late], 1)[0] / D - 1.0, stress[behind].mean() / P - 1.0,
            found[behind].mean() / density - 1.0, stress[behind].std() / P)


def test_a_front_without_a_grid_wants_damping_too():
    speed, _, density, ripple = errors_of_elements(0.0, 0.0)
    assert speed < -0.05 and density > 0.05 and ripple > 0.1  # of 3, 2 and 0 asked
    assert np.abs(errors_of_elements(0.06, 1.5)).max() < 0.005


DAMPED = Scheme("flip", 0.95)


@pytest.mark.parametrize(("law", "kind", "speed", "length", "scheme"), [
    (FIRM, "firm", 4.3, 1.5, APIC), (FIRM, "firm", 4.3, 1.5, FLIP),
    pytest.param(FRESH, "fresh", 1.0, 4.5, APIC, marks=pytest.mark.slow),
    pytest.param(FRESH, "fresh", 4.3, 4.5, DAMPED, marks=pytest.mark.slow)],
    ids=["firm-apic", "firm-flip", "fresh-slow-apic", "fresh-flip-damped"])
def test_front_and_what_it_leaves(law, kind, speed, length, scheme):
    D, P, density = FRONTS[kind, speed]
    found, stress, behind, work = drive(law, scheme, speed, (D, P, density), length)
    assert found == pytest.approx(D, rel=0.03) and stress == pytest.approx(P, rel=0.03)
    assert behind == pytest.approx(density, rel=0.02) and work > 0.0


@pytest.mark.slow
@pytest.mark.parametrize("cfl", [pytest.param(None, marks=pytest.mark.xfail(strict=True, reason=(
    "3.02 % too slow: the usual step is longer than when the table above was made"))), 0.25])
def test_speed_of_an_undamped_front_in_fresh_snow(cfl):
    D, P, density = FRONTS["fresh", 4.3]
    assert drive(FRESH, replace(APIC, cfl=cfl), 4.3, (D, P, density), 4.5)[0] == pytest.approx(D, rel=0.03)


@pytest.mark.slow
@pytest.mark.xfail(strict=True, reason="the front of APIC rings, see above: stress 4 % low, density 2.3 % high")
def test_state_behind_an_undamped_front_in_fresh_snow():
    D, P, density = FRONTS["fresh", 4.3]
    _, stress, behind, _ = drive(FRESH, APIC, 4.3, (D, P, density), 4.5)
    assert stress == pytest.approx(P, rel=0.03) and behind == pytest.approx(density, rel=0.02)
