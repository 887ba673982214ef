"""The same bits for any number of threads, and again."""

import pytest

from tests.support.thread_counts import with_one_and_two_threads

from .determinism_cases import CASES, QUICK


@pytest.mark.parametrize("names", [
    pytest.param(QUICK, id="quick"),
    pytest.param(tuple(name for name in CASES if name not in QUICK), id="others", marks=pytest.mark.slow)])
def test_one_and_two_threads_and_again_leave_the_same_bits(names):
    """Run twice with one thread and twice with two; every part of the step takes part."""
    outcomes = [run for one in with_one_and_two_threads("tests.mpm.determinism_cases", *names) for run in one["runs"]]
    hashes = {name: {run[name]["hash"] for run in outcomes} for name in names}
    assert {name: len(found) for name, found in hashes.items()} == dict.fromkeys(names, 1)
    assert len(set().union(*hashes.values())) == len(names)
    for case in (case for run in outcomes for case in run.values()):
        assert not case["alone"]  # one code, whatever the number of threads
        assert case["sorts"] >= 1 and case["blocks"] >= 4
        assert min(case[name] for name in ("plastic_work", "between_bodies", "terrain", "obstacle")) > 0.0
