"""Order of convergence of a number over a grid of cells."""

import numpy as np
import pytest

from snowmpm.campaigns.order import order, order_of_errors


@pytest.mark.parametrize("p", [0.5, 1.0, 2.0, 3.0])
@pytest.mark.parametrize("h", [(0.4, 0.2, 0.1), (0.3, 0.2, 0.12), (1.0, 0.5, 0.2, 0.1)])
def test_a_power_is_found_with_its_limit(p, h):
    h = np.array(h)
    found = order(h, 7.0 + 3.0 * h**p)
    assert found == pytest.approx((p, 7.0), rel=1e-6)
    assert order_of_errors(h, 0.2 * h**p) == pytest.approx(p)


def test_what_has_no_order():
    h = np.array([0.4, 0.2, 0.1])
    assert order(h, [1.0, 2.0, 1.5]) is None  # alternates
    assert order(h, [1.0, 2.0, 4.0]) is None  # differences grow
    assert order(h, [1.0, 1.0, 1.0]) is None and order(h[:2], [1.0, 2.0]) is None
    assert order(h, [1.0, np.nan, 2.0]) is None
    assert order_of_errors(h, [0.1, 0.2, 0.3]) is None and order_of_errors(h, [0.1, 0.0, 0.1]) is None
