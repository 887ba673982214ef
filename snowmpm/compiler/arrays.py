"""Small tables for kernels."""

import numpy as np

from snowmpm.compiler import array_memory, lifetime
from snowmpm.compiler.backend import ti


def int_array(values):
    """Taichi copy of an integer NumPy array; an empty one keeps one row so that kernels can take it."""
    values = np.ascontiguousarray(values, np.int32)
    if values.size == 0:
        values = np.zeros((1, *values.shape[1:]), np.int32)
    array = ti.ndarray(ti.i32, values.shape)
    array.from_numpy(values)
    return array


def real_array(values):
    """Taichi copy of a small table of numbers, float64; cheaper to launch a kernel with than a NumPy array."""
    values = np.array(values, np.float64)
    array = ti.ndarray(ti.f64, values.shape)
    array.from_numpy(values)
    return array


class Rows:
    """A table of integers that is filled again and again, a few more or fewer rows each time, in the same memory: to
    make and free a Taichi array takes 100 us, whatever its size."""

    def __init__(self):
        self._array = self._view = None

    def filled(self, values):
        """Taichi array that begins with `values` (n, ...), integers; what follows means nothing. It is the same one, or
        one with more rows; whatever was filled before is gone."""
        values = np.asarray(values)
        if not array_memory.is_shared() or not len(values):
            return int_array(values)
        if self._view is not None:
            lifetime.check(lifetime.start_of(self._array), "this table")
        if self._view is None or self._view.shape[1:] != values.shape[1:] or len(self._view) < len(values):
            self._array = ti.ndarray(ti.i32, (len(values) + len(values) // 4 + 8, *values.shape[1:]))
            self._view = array_memory.view(self._array)
        self._view[: len(values)] = values
        return self._array
