"""The kernels of a GPU against those of a CPU: one particle a thread with atomics, against packs in a fixed order.

They are run on a GPU where there is one, and on the CPU in any case: the same source, layout of the particles by
columns, cut of the work and atomic sums; only the compiler's back end differs.
"""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from snowmpm.compiler.runtime import _has_cuda
from tests.gpu.steps import CASES, GROWTH

WAYS = ["fine", pytest.param("cuda", marks=pytest.mark.skipif(not _has_cuda(), reason="needs a GPU"))]
STEPS = Path(__file__).with_name("steps.py")


@pytest.fixture(scope="module")
def steps(tmp_path_factory):
    """steps(way, precision) -> what `steps.py` found."""
    folder, found = tmp_path_factory.mktemp("steps"), {}

    def run(way, precision):
        if (way, precision) not in found:
            path = folder / f"{way}_{precision}.npz"
            subprocess.run([sys.executable, str(STEPS), way, precision, str(path)], check=True)
            found[way, precision] = dict(np.load(path))
        return found[way, precision]

    return run


@pytest.mark.slow
@pytest.mark.parametrize("precision", ["f64", "f32"])
@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("case", CASES)
def test_both_kinds_of_kernels_agree(steps, case, way, precision):
    expected, found = steps("packs", precision), steps(way, precision)
    for key in ("position", "velocity", "load"):
        a, b = expected[f"{case}/{key}"], found[f"{case}/{key}"]
        assert a.shape == b.shape
        assert np.abs(a - b).max() <= GROWTH[way, precision] * np.abs(a).max(), key
    if precision == "f64" and way == "fine":
        np.testing.assert_array_equal(expected[f"{case}/plastic"], found[f"{case}/plastic"])


@pytest.mark.slow
@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("case", CASES)
def test_two_numbers_an_entry_change_only_round_off(steps, case, way):
    """To round-off: the compiler may sum in another order."""
    expected, found = steps(way, "f32"), steps("paired" if way == "fine" else "cuda_paired", "f32")
    assert not expected[f"{case}/paired"] and found[f"{case}/paired"] == (case != "columns")
    for key in ("position", "velocity", "load"):
        a, b = expected[f"{case}/{key}"], found[f"{case}/{key}"]
        assert np.abs(a - b).max() <= GROWTH[way, "f32"] * np.abs(a).max(), key
