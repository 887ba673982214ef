"""Saw tests by steps at rest (I7): an elastic layer that is cut, beside WEAC and finite elements (S1).

The column of `study.problems.elastic_saw_test`, from the state of an infinite slope to its balance in one step for each
cut; see there and in `test_elastic_saw_test` for what WEAC leaves out.
"""

import numpy as np
import pytest

from snowmpm.study.problems.elastic_saw_test import FLAT
from tests.support.implicit_saw_test import at_rest

CUTS = (0.3, 0.5)


def test_deflection_and_energy_release_rate_on_the_flat():
    """S1 asks for 5 % and 8 %."""
    (before, _), (after, end) = (at_rest(cut) for cut in CUTS)
    rate = (before - after) / (CUTS[1] - CUTS[0])
    assert rate == pytest.approx(FLAT[0], rel=0.08)
    assert end == pytest.approx(FLAT[1], rel=0.05)
    assert np.isfinite(rate)
