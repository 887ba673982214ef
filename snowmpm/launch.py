"""Launching kernels at little cost.

Before each launch Taichi compares every argument with every kind of argument it knows: 60 to 90 us for the 8 to 18 of
a kernel here, as long as a thousand particles take in 2-D (measured). But what a kernel takes is known when it is
defined, numbers and arrays, and what the arrays hold seldom changes from one launch to the next.
"""

import contextlib
import functools
import gc
import operator

import numpy as np
import taichi as ti
from taichi.lang import impl
from taichi.types import ndarray_type, primitive_types


def taichi_kernel(function):
    """`ti.kernel`, by a `Launcher` if the function takes numbers and arrays only and returns nothing."""
    kernel = ti.kernel(function)
    setters = [_setter(argument.annotation) for argument in kernel._primal.arguments]
    if None in setters or kernel._primal.return_type is not None:
        return kernel
    return functools.wraps(function)(Launcher(kernel, setters))


class Launcher:
    """A kernel, and what Taichi compiled of it by what its arrays hold.

    Arrays are Taichi's or NumPy's, the latter of numbers only and without gaps. Raises TypeError for a number that is
    none, and what Taichi raises for an array that the kernel does not take.
    """

    def __init__(self, kernel, setters):
        self._kernel = kernel._primal
        self._setters = [((i,), setter) for i, setter in enumerate(setters)]
        self._arrays = [i for i, setter in enumerate(setters) if setter is _set_array]
        self._program, self._compiled = None, {}

    def __call__(self, *args):
        key = tuple([_kind(args[i]) for i in self._arrays])
        if self._program is not impl.get_runtime().prog or key not in self._compiled:
            self._compile(key, args)
        kernel, code = self._compiled[key]
        context = kernel.make_launch_context()
        for (place, setter), value in zip(self._setters, args, strict=True):
            setter(context, place, value)
        self._program.launch_kernel(code, context)

    def _compile(self, key, args):
        program = impl.get_runtime().prog
        if self._program is not program:
            self._program, self._compiled = program, {}
        with _no_collection():
            kernel = self._kernel.compiled_kernels[self._kernel.ensure_compiled(*args)]
        code = program.compile_kernel(program.config(), program.get_device_caps(), kernel)
        self._compiled[key] = kernel, code


@contextlib.contextmanager
def _no_collection():
    """Spare Python the search for garbage in the many small things that a kernel is made of."""
    collected = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if collected:
            gc.enable()


def _kind(array):
    """What an array holds, and its number of axes."""
    if isinstance(array, np.ndarray):
        return array.dtype.num, array.ndim
    return array.element_type, len(array.shape)


def _setter(annotation):
    if isinstance(annotation, ndarray_type.NdarrayType):
        return _set_array
    if id(annotation) in primitive_types.real_type_ids:
        return _set_real
    if id(annotation) in primitive_types.integer_type_ids:
        return _set_integer
    return None


def _set_real(context, place, value):
    context.set_arg_float(place, float(value))


def _set_integer(context, place, value):
    context.set_arg_int(place, operator.index(value))


def _set_array(context, place, array):
    if isinstance(array, np.ndarray):
        if not array.flags.c_contiguous:
            raise ValueError("a kernel takes arrays without gaps, see numpy.ascontiguousarray")
        address = array.__array_interface__["data"][0]
        context.set_arg_external_array_with_shape(place, address, array.nbytes, array.shape, 0)
    else:
        context.set_arg_ndarray(place, array.arr)
