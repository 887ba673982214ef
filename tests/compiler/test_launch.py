"""Launching a kernel without Taichi's own look at each argument."""

import numpy as np
import pytest
import taichi as ti

from snowmpm.compiler import patches
from snowmpm.compiler.arrays import real_array
from snowmpm.compiler.launch import Launcher, taichi_kernel


@taichi_kernel
def add_scaled(target: ti.types.ndarray(), source: ti.types.ndarray(), factor: ti.f64, first: ti.i32):
    for i in range(source.shape[0]):
        target[first + i] += factor * source[i]


pytestmark = [pytest.mark.usefixtures("taichi"),
              pytest.mark.skipif(not patches.wanted("launch"), reason="the patch launch is switched off")]


def test_arrays_of_either_kind():
    """Taichi's or NumPy's, of any type that the kernel takes: one compiled kernel for each."""
    assert isinstance(add_scaled, Launcher)
    for number in (np.float32, np.float64):
        target = np.ones(4, number)
        add_scaled(target, np.arange(3, dtype=number), np.float64(2.0), np.int64(1))
        np.testing.assert_array_equal(target, [1.0, 1.0, 3.0, 5.0])
    target = real_array(np.ones(4))
    add_scaled(target, real_array(np.arange(3)), 2, 1)
    np.testing.assert_array_equal(target.to_numpy(), [1.0, 1.0, 3.0, 5.0])


def test_what_a_kernel_does_not_take():
    target, source = np.zeros(4), np.zeros(2)
    with pytest.raises(TypeError):
        add_scaled(target, source, 1.0, 1.5)
    with pytest.raises(TypeError):
        add_scaled(target, source, None, 1)
    with pytest.raises(ValueError, match="without gaps"):
        add_scaled(target, np.zeros(4)[::2], 1.0, 0)
    with pytest.raises(ValueError):
        add_scaled(target, source, 1.0)
    assert not target.any()


def test_kernels_that_return_something_are_left_to_taichi():
    @taichi_kernel
    def doubled(x: ti.f64) -> ti.f64:
        return 2.0 * x

    assert not isinstance(doubled, Launcher) and doubled(1.5) == 3.0
