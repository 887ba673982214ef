"""Launching a kernel without Taichi's own look at each argument."""

import weakref

import numpy as np
import pytest

from snowmpm.compiler import patches, ti
from snowmpm.compiler.arrays import real_array
from snowmpm.compiler.launch import Launcher, own_launches, taichi_kernel


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


@taichi_kernel
def put(target: ti.types.ndarray(), number: ti.f64, place: ti.i32):
    for _ in range(1):
        target[place] = number


def test_what_changed_since_the_last_launch_arrives():
    """An array, a number, both or none; of arrays that are gone nothing is left."""
    for rounds in range(3):
        array = real_array(np.zeros(2))
        for number, place in ((1.5, 0), (1.5, 0), (1.5, 1), (2.5 + rounds, 1)):
            put(array, number, place)
        np.testing.assert_array_equal(array.to_numpy(), [1.5, 2.5 + rounds])
        other = np.zeros(3)
        put(other, 2.5 + rounds, 1)
        put(array, 0.5, 0)
        np.testing.assert_array_equal(other, [0.0, 2.5 + rounds, 0.0])
        np.testing.assert_array_equal(array.to_numpy(), [0.5, 2.5 + rounds])
        del array


def test_numbers_are_told_apart():
    """Zero of either sign is another number, and one that can change in place is never taken for known."""
    target, changing = real_array(np.ones(1)), np.array(1.0)
    put(target, 0.0, 0)
    put(target, -0.0, 0)
    assert np.signbit(target.to_numpy()[0])
    for value in (3.0, 4.0):
        changing[...] = value
        put(target, changing, 0)
        assert target.to_numpy()[0] == value


def test_a_launch_keeps_no_array_alive():
    array = real_array(np.zeros(2))
    put(array, 1.0, 0)
    gone = weakref.ref(array)
    del array
    assert gone() is None


def test_an_array_of_other_numbers_is_compiled_for_between_two_of_the_same():
    one, other = np.zeros(1), np.zeros(1, np.float32)
    for value in (1.0, 2.0):
        put(one, value, 0)
        put(other, value, 0)
        assert one[0] == other[0] == value


def test_two_owners_of_a_kernel_launch_it_in_turn():
    one, other = own_launches(put), own_launches(put)
    arrays = real_array(np.zeros(1)), real_array(np.zeros(1))
    for value in (1.0, 2.0):
        one(arrays[0], value, 0)
        other(arrays[1], -value, 0)
        assert [array.to_numpy()[0] for array in arrays] == [value, -value]
    assert own_launches(len) is len
