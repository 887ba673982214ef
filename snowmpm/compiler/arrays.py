"""Small tables for kernels."""

import numpy as np
import taichi as ti


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
