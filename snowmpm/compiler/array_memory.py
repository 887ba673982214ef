"""Taichi's arrays where NumPy can reach them: on a CPU both have the same memory.

Taichi copies by a kernel, 150 us for ten numbers, and writes out the Python stack for every array that it makes, 250 us
(measured): more than a step of a thousand particles, each time that particles change blocks or an obstacle moves.
"""

import ctypes
import math

import numpy as np

from snowmpm.compiler import lifetime, patches
from snowmpm.compiler.backend import impl, part, ti

COPIES = ("_ndarray_from_numpy", "_ndarray_matrix_from_numpy", "_ndarray_to_numpy", "_ndarray_matrix_to_numpy")
"""How Taichi itself fills and copies arrays."""

WRITABLE = 0x200
"""PyBUF_WRITE."""

_memory = ctypes.pythonapi.PyMemoryView_FromMemory
_memory.restype, _memory.argtypes = ctypes.py_object, (ctypes.c_void_p, ctypes.c_ssize_t, ctypes.c_int)

_taichis = {}


def share(on_cpu):
    """Let Taichi fill and copy arrays by their memory, where that is the processor's, and make them without a look at
    the Python stack."""
    if patches.apply("array_memory", _install):
        for name, taichis in _taichis.items():
            setattr(ti.Ndarray, name, _own(name) if on_cpu else taichis)


def is_shared():
    """Whether NumPy reaches the arrays of the Taichi that runs."""
    return patches.is_applied("array_memory") and vars(ti.Ndarray).get(COPIES[0]) is _fill


def _install():
    _ndarray, matrix = part("lang._ndarray"), part("lang.matrix")

    _taichis.update({name: vars(ti.Ndarray)[name] for name in COPIES})
    for name in COPIES:
        patches.replace("array_memory", ti.Ndarray, name, _own(name))
    for module in (_ndarray, matrix):
        patches.replace("array_memory", module, "get_traceback", lambda *levels: "")


def _own(name):
    return _fill if "from" in name else _copy


def view(array):
    """NumPy array over the memory of a Taichi array, of its shape and that of its elements; valid as long as it is.

    Raises EndedError for an array of a Taichi that was ended.
    """

    lifetime.check(lifetime.start_of(array), "this array")
    shape, kind = tuple(array.arr.total_shape()), np.dtype(part("lang.util").to_numpy_type(array.dtype))
    address = impl.get_runtime().prog.get_ndarray_data_ptr_as_int(array.arr)
    # A ctypes array would need a type of its own for every length, which takes longer than all the rest
    return np.frombuffer(_memory(address, math.prod(shape) * kind.itemsize, WRITABLE), kind).reshape(shape)


def _fill(array, values, as_vector=None):
    memory = view(array)
    if not isinstance(values, np.ndarray) or values.shape != memory.shape:
        raise ValueError(f"an array of shape {memory.shape} cannot take {np.shape(values)}")
    memory[...] = values


def _copy(array, as_vector=None):
    return view(array).copy()
