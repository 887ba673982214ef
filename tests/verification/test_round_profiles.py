"""B16: the heap of a round column over the distance from its middle, by MPM and by SPH (Lube et al. 2004,
doi:10.1017/S0022112004009036; the columns a = 0.55 and 0.9 of Bui and Nguyen 2021, figure 30).

Known in numbers are run-out and height, and that a column lower than 0.74 radii keeps a disc of its top. The curves of
the experiments were not at hand: the surface in between is held against the one that the other method gives.
"""

import numpy as np
import pytest

from tests.support.round_columns import RADIUS, collapsed, depths, disc, heap, published

pytestmark = pytest.mark.slow

LOW = ("a = 0.9: 15.2 % (MPM) and 19.5 % (SPH) too low against h = a; Favero Neto and Borja (2018), eq. 40, fit 0.87 a"
       " to theirs")


@pytest.fixture(scope="module", params=[0.55, 0.9])
def column(request, tmp_path_factory):
    """a, {method: `Case`}, {method: `Profile`}."""
    cases = {method: collapsed(request.param, method, tmp_path_factory.mktemp(method)) for method in ("mpm", "sph")}
    return request.param, cases, {method: heap(case) for method, case in cases.items()}


def test_run_out(column):
    a, _, heaps = column
    for found in heaps.values():
        assert found.front == pytest.approx(published(a)[0], rel=0.15)


def test_height_of_the_middle(column, request):
    a, _, heaps = column
    if a > 0.74:
        request.applymarker(pytest.mark.xfail(strict=True, reason=LOW))
    for found in heaps.values():
        near = found.s < max(0.1 * RADIUS, found.s[0] + 1e-9)
        assert found.top[near].mean() == pytest.approx(published(a)[1], rel=0.15)


def test_height_of_the_middle_as_simulated(column):
    """Above a = 0.74: 0.87 a, which Favero Neto and Borja (2018), eq. 40, fit to their own runs, to 10 %."""
    a, _, heaps = column
    wanted = 0.87 * a * RADIUS if a > 0.74 else published(a)[1]
    for found in heaps.values():
        near = found.s < max(0.1 * RADIUS, found.s[0] + 1e-9)
        assert found.top[near].mean() == pytest.approx(wanted, rel=0.1)


def test_both_methods_leave_one_heap(column):
    """Depths differ by less than a tenth of the column's height in the mean, out to the published run-out."""
    a, cases, _ = column
    r = np.linspace(0.0, published(a)[0], 200)
    (one, other) = (np.interp(r, *depths(case), right=0.0) for case in cases.values())
    apart = np.abs(one - other).mean() / (a * RADIUS)
    print(f"a = {a:g}: apart by {100 * apart:.1f} % of the height")
    assert apart < 0.1


def test_low_columns_keep_a_disc_of_their_top(column):
    """Below a = 0.74 a disc stays as it was, a quarter of the radius wide or more; above, nothing does."""
    a, cases, heaps = column
    for method, found in heaps.items():
        assert (disc(found, cases[method]) > 0.25 * RADIUS) == (a < 0.74)
