"""The same bits for any number of threads, and after a checkpoint."""

import numpy as np
import pytest

from tests.sph.determinism_cases import CASES, numbers, stage
from tests.support.thread_counts import with_one_and_two_threads


@pytest.mark.slow
def test_one_and_two_threads_leave_the_same_bits():
    told = with_one_and_two_threads("tests.sph.determinism_cases")
    assert told[0]["cases"] == told[1]["cases"]
    for case in told[0]["cases"].values():
        assert case["sorts"] >= 3
        assert min(case[name] for name in ("plastic_work", "terrain", "obstacle")) > 0.0
    assert len({case["hash"] for case in told[0]["cases"].values()}) == len(CASES)


@pytest.mark.parametrize("name", ["2-D"])
def test_a_restored_solver_goes_on_bit_by_bit(name):
    """Between two searches for neighbours, whose lists the state brings back."""
    one, other = stage(*CASES[name]), stage(*CASES[name])
    for _ in range(17):
        one.step(one.stable_dt()[0])
    state = one.state()
    sorts = one.particles.sorts
    assert state["neighbours"]["closed_in"] > 0.05
    other.restore(state)
    while one.particles.sorts < sorts + 2:
        one.step(one.stable_dt()[0])
        other.step(other.stable_dt()[0])
    for a, b in zip(numbers(one), numbers(other), strict=True):
        assert np.ascontiguousarray(a).tobytes() == np.ascontiguousarray(b).tobytes()
