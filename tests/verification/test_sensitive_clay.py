"""F6 (B18): a slope of sensitive clay that fails backwards, by the scene of the guide on three grids."""

import numpy as np
import pytest

from tests.support.sensitive_clay import GRIDS, RUN_OUT, TIMES, slope

OFF = 0.1
"""Of the run-out."""


@pytest.mark.slow
@pytest.mark.parametrize("dx", GRIDS)
def test_the_clay_runs_out_as_published(dx):
    last = slope(dx)[-1]
    print(f"dx = {dx:.3f} m: tip {[round(float(one.run_out), 1) for one in slope(dx)]} m at {TIMES} s, 99 % within"
          f" {last.of_most:.1f} m, scarp {last.scarp:.1f} m, {100 * (last.strain > 0.4).mean():.0f} % remoulded")
    assert last.run_out == pytest.approx(RUN_OUT, rel=OFF)
    assert last.speed < 0.5


@pytest.mark.slow
def test_it_fails_backwards():
    """The scarp goes back after the first slide, and what lies behind it is as it was."""
    early, _, last = slope(GRIDS[0])
    assert last.scarp < early.scarp - 5.0
    intact = last.x[:, 0] < last.scarp - 3.0
    assert intact.sum() > 100 and np.median(last.strain[intact]) < 0.05


@pytest.mark.slow
def test_without_f_bar_its_cells_lock_and_it_stands():
    assert slope(GRIDS[0], f_bar=False)[-1].run_out < 0.5
