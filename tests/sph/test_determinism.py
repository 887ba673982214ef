"""The same bits for any number of threads, and after a checkpoint."""

import numpy as np
import pytest

from snowmpm.sph import shortlist
from tests.sph.determinism_cases import CASES, numbers, stage
from tests.support.thread_counts import with_one_and_two_threads

HASTE, STEPS = 0.25, 90
"""Slow enough for short lists, and so long that lists are made anew."""


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


@pytest.mark.parametrize("name", ["2-D", pytest.param("3-D", marks=pytest.mark.slow)])
def test_short_lists_of_neighbours_give_the_sums_of_the_long_ones(name, monkeypatch):
    """To the bit, over several searches for neighbours; and they are cut again and again, and shorter."""
    short, left = stage(*CASES[name], haste=HASTE), []
    for _ in range(STEPS):
        short.step(short.stable_dt()[0])
        of_particles = short._near.of_particles
        lists, ends = short._near.lists, np.zeros(2)
        for k, read in enumerate((of_particles, lists)):
            own, amount = read.runs.to_numpy(), read.n_runs.to_numpy()
            last = np.arange(short._near.packs.n) * lists.most_runs + amount[: short._near.packs.n] - 1
            ends[k] = own[last, 1].sum()
        left.append(ends[0] / ends[1])
    assert short.particles.sorts >= 2
    assert len(set(left)) >= 4
    assert np.median(left) < 0.95
    monkeypatch.setattr(shortlist, "WORTH", 0.0)
    long = stage(*CASES[name], haste=HASTE)
    for _ in range(STEPS):
        long.step(long.stable_dt()[0])
    assert long._near.of_particles.entries is long._near.lists.entries
    for a, b in zip(numbers(short), numbers(long), strict=True):
        assert np.ascontiguousarray(a).tobytes() == np.ascontiguousarray(b).tobytes()
