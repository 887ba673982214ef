"""Order of convergence of a number over a grid of cells."""

from types import SimpleNamespace

import numpy as np
import pytest

from snowmpm.campaigns.distributions import Choices
from snowmpm.campaigns.order import interval, order, order_of_errors, orders


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


def test_the_reference_stands_first_with_its_order_for_each_choice_of_the_others():
    """Errors of 0.3 h^2 and 0.1 h for two transfers."""
    from snowmpm.campaigns.listing import listing
    from snowmpm.campaigns.table import frame_of

    sizes, laws = (0.1, 0.4, 0.2), {"apic": lambda h: 0.3 * h**2, "flip": lambda h: 0.1 * h}
    table = frame_of([{"dx": h, "transfer": name, "status": "done", "mass": 3.0, "max_speed": 1.0 + error(h),
                       "reference_tip_deflection": 2.0 * (1.0 + error(h)), "reference_tip_deflection_error": error(h)}
                      for name, error in laws.items() for h in sizes])
    file = SimpleNamespace(parameters={
        "dx": Choices(key="solver.dx", distribution="choices", values=sizes),
        "transfer": Choices(key="solver.transfer", distribution="choices", values=tuple(laws))})
    campaign = SimpleNamespace(table=table, dimension=2, file=file, example=None,
                               values=lambda name: table[name].to_numpy(float))
    assert listing(campaign, 10)[0].split()[:4] == ["dx", "transfer", "reference_tip_deflection",
                                                    "reference_tip_deflection_error"]
    told = orders(campaign, ["reference_tip_deflection", "max_speed"])
    assert told[1] == "transfer apic: fastest particle 1.003 ± 0.004 m/s on cells of 0.1 m, order 2"
    assert [line.partition(": ")[0] for line in told] == ["transfer apic"] * 2 + ["transfer flip"] * 2
    assert told[0].endswith("order 2 against the reference") and told[2].endswith("order 1 against the reference")


def test_the_interval_holds_the_limit_and_shrinks_with_the_grid():
    """Of three grids by the order that they show, of two by one of 1 and more caution."""
    h = np.array([0.4, 0.2, 0.1])
    values = 7.0 + 3.0 * h**2
    assert interval(h, values) == pytest.approx(1.25 * 0.03) and abs(values[-1] - 7.0) < interval(h, values)
    assert interval(h[:2], values[:2]) == pytest.approx(3.0 * 0.36) and interval(h[:1], values[:1]) is None
    assert interval(h, [1.0, 2.0, 1.5]) == pytest.approx(1.5) and interval(h, [1.0, np.nan, 1.0]) is None
