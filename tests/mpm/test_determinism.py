"""The same bits for any number of threads, and again."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from .determinism_cases import CASES

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def outcomes():
    """What every case leaves, run twice with one thread and twice with two: four {case: outcome}."""
    command = [sys.executable, "-m", "tests.mpm.determinism_cases"]
    at_work = [subprocess.Popen([*command, str(threads)], cwd=ROOT, text=True, stdout=subprocess.PIPE)
               for threads in (1, 2)]
    said = [process.communicate(timeout=600)[0] for process in at_work]
    assert [process.returncode for process in at_work] == [0, 0]
    told = [json.loads(text.splitlines()[-1]) for text in said]
    assert [one["threads"] for one in told] == [1, 2]
    return [run for one in told for run in one["runs"]]


@pytest.mark.parametrize("case", CASES)
def test_one_and_two_threads_and_again_leave_the_same_bits(outcomes, case):
    first, *others = (run[case]["hash"] for run in outcomes)
    assert others == [first] * 3
    assert not any(run[case]["alone"] for run in outcomes)  # one code, whatever the number of threads


def test_every_part_of_the_step_took_part(outcomes):
    for case in outcomes[0].values():
        assert case["sorts"] >= 1 and case["blocks"] >= 4
        assert min(case[name] for name in ("plastic_work", "between_bodies", "terrain", "obstacle")) > 0.0
    assert len({case["hash"] for case in outcomes[0].values()}) == len(CASES)
