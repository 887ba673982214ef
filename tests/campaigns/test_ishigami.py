"""C2: the Ishigami function through workers, table and sensitivities.

f = sin x1 + 7 sin² x2 + 0.1 x3⁴ sin x1, x in (-pi, pi); its indices in closed form: first order .3139, .4424, 0, total
.5576, .4424, .2437 (Ishigami, Homma 1990, doi:10.1109/ISUMA.1990.151285)."""

import math

import numpy as np
import pytest

FIRST, TOTAL = (0.3139, 0.4424, 0.0), (0.5576, 0.4424, 0.2437)
PARAMETERS = {f"x{k}": {"distribution": "uniform", "low": -math.pi, "high": math.pi} for k in (1, 2, 3)}


def ishigami(values):
    x1, x2, x3 = (values[name] for name in ("x1", "x2", "x3"))
    return {"f": math.sin(x1) + 7.0 * math.sin(x2) ** 2 + 0.1 * x3**4 * math.sin(x1)}


def test_indices_of_a_saltelli_design(site):
    from tests.support.campaign_of_function import evaluate_campaign

    table, found = evaluate_campaign(ishigami, PARAMETERS, site, design="saltelli", runs=2**12)
    assert len(table) == 5 * 2**12 and (table.status == "done").all()
    assert table.f[7] == ishigami(dict(table.iloc[7]))["f"]
    found = found.set_index("parameter").loc[["x1", "x2", "x3"]]
    assert found["first"].to_numpy() == pytest.approx(FIRST, abs=0.02)
    assert found["total"].to_numpy() == pytest.approx(TOTAL, abs=0.02)
    assert (found.first_low <= found["first"]).all() and (found["first"] <= found.first_high).all()


def test_indices_of_an_emulator(site):
    """A polynomial of degree 6 cannot follow sin² to more than some per cent, and says so by its quality."""
    from tests.support.campaign_of_function import evaluate_campaign

    _, found = evaluate_campaign(ishigami, PARAMETERS, site, design="latin_hypercube", runs=400)
    found = found.set_index("parameter").loc[["x1", "x2", "x3"]]
    assert 0.8 < found.quality.iloc[0] < 1.0
    assert found["first"].to_numpy() == pytest.approx(FIRST, abs=0.05)
    assert found["total"].to_numpy() == pytest.approx(TOTAL, abs=0.05)


def test_a_failing_value_is_a_failed_row(site):
    from tests.support.campaign_of_function import evaluate_campaign

    def often(values):
        if values["x1"] > 2.0:
            raise ValueError("too large")
        return {"f": values["x1"]}

    table, _ = evaluate_campaign(often, PARAMETERS, site, design="sobol", runs=64)
    failed = table.x1 > 2.0
    assert failed.any() and (table.status[failed] == "failed").all() and (table.status[~failed] == "done").all()
    assert table.reason[failed].str.contains("ValueError: too large").all()
    assert np.isnan(table.f[failed]).all()
