"""Copies between NumPy and Taichi's arrays."""

import numpy as np
import pytest

from snowmpm.compiler import patches, ti
from snowmpm.compiler.array_memory import view
from snowmpm.compiler.arrays import Rows
from snowmpm.compiler.launch import taichi_kernel

pytestmark = [pytest.mark.usefixtures("taichi"),
              pytest.mark.skipif(not patches.wanted("array_memory"), reason="the patch array_memory is switched off")]


@taichi_kernel
def double(numbers: ti.types.ndarray()):
    for i in range(numbers.shape[0]):
        numbers[i] = 2 * numbers[i]


@pytest.mark.parametrize("kind", [ti.u8, ti.i32, ti.f32, ti.f64])
def test_numbers_go_to_a_kernel_and_back(kind):
    array = ti.ndarray(kind, 5)
    array.from_numpy(np.arange(5.0))
    double(array)
    back = array.to_numpy()
    np.testing.assert_array_equal(back, 2.0 * np.arange(5))
    back[:] = 7  # a copy: the array keeps its own
    assert array[3] == 6


def test_vectors():
    array = ti.ndarray(ti.types.vector(4, ti.f32), 3)
    array.from_numpy(np.arange(12.0, dtype=np.float32).reshape(3, 4))
    assert tuple(array[2]) == (8.0, 9.0, 10.0, 11.0)
    double(array)
    np.testing.assert_array_equal(array.to_numpy(), 2.0 * np.arange(12).reshape(3, 4))


def test_other_shapes_are_refused():
    array = ti.ndarray(ti.f64, (2, 3))
    for values in (np.zeros((3, 2)), np.zeros(6), np.zeros((1, 3)), 0.0):
        with pytest.raises(ValueError, match="cannot take"):
            array.from_numpy(values)


def test_one_memory():
    array = ti.ndarray(ti.f64, (2, 3))
    view(array)[1, 2] = 4.5
    assert array[1, 2] == 4.5


def test_rows_are_filled_again_in_the_same_memory_until_there_are_too_many():
    rows = Rows()
    first = rows.filled(np.arange(4))
    again = rows.filled(np.array([7, 8]))
    assert again is first
    double(again)
    np.testing.assert_array_equal(again.to_numpy()[:4], [14, 16, 4, 6])
    many = rows.filled(np.arange(100))
    assert many is not first
    np.testing.assert_array_equal(many.to_numpy()[:100], np.arange(100))
    wide = rows.filled(np.arange(8).reshape(4, 2))
    np.testing.assert_array_equal(wide.to_numpy()[:4], np.arange(8).reshape(4, 2))
    assert rows.filled(np.zeros((0, 2), int)).shape == (1, 2)  # kernels take no empty array


def test_rows_of_a_taichi_that_copies_itself(monkeypatch):
    """On a GPU, or without the patch, NumPy does not reach the memory of an array."""
    monkeypatch.setattr("snowmpm.compiler.array_memory.is_shared", lambda: False)
    rows = Rows()
    first, again = rows.filled(np.array([1, 2, 3])), rows.filled(np.array([4, 5]))
    assert again is not first
    np.testing.assert_array_equal(first.to_numpy(), [1, 2, 3])
    np.testing.assert_array_equal(again.to_numpy(), [4, 5])
