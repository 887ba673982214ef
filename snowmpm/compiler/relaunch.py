"""Launching a kernel again with mostly the same arguments, as steps do: only what changed is told to Taichi.

To tell it an array takes 2 to 3 us, and to forget them all at the end of a launch as long: 30 us for 12 arguments, 5 us
where one number of them changed (measured). Arrays are told by the address of their memory, which stays. By an array of
Taichi's own it would find the memory at each launch, and must be told of it each time.

This is the patch `relaunch` (`snowmpm.compiler.patches`), on a CPU only: without it every launch is told everything.
"""

import math
import weakref

import numpy as np

from snowmpm.compiler import patches
from snowmpm.compiler.backend import impl, ti


def applied(start):
    """Whether launches of this start of Taichi are done again."""
    return patches.apply("relaunch", _look) and start.prog.config().arch in (ti.x64, ti.arm64)


def _look():
    """Look for all that is used here of a kernel that is compiled."""
    core = impl._ti_core
    core.Program.get_ndarray_data_ptr_as_int, core.KernelLaunchContext.set_arg_external_array_with_shape  # noqa: B018


class Relaunch:
    """A launch of compiled `code`, and what it was told.

    kinds: {place: kind} of its arrays; setters: [(place, function)] of all arguments. Arrays are not kept alive.
    """

    __slots__ = ("_arrays", "_numbers", "_size", "code", "context")

    def __init__(self, code, context, kinds, setters):
        self.code, self.context, self._size = code, context, len(setters)
        self._arrays = [[i, _nothing, kind] for i, kind in kinds.items()]
        self._numbers = [[place[0], _nothing, place, setter] for place, setter in setters if place[0] not in kinds]

    def take(self, args, kind_of):
        """Tell what is another argument than at the last launch; -> whether the kernel takes these: as many, and arrays
        of the same kinds, `kind_of(array)`."""
        if len(args) != self._size:
            return False
        for known in self._arrays:
            array = args[known[0]]
            if known[1]() is not array:
                if kind_of(array) != known[2]:
                    return False
                known[1] = _nothing  # should telling fail
                self._tell(known[0], array)
                known[1] = weakref.ref(array)
        for known in self._numbers:
            number = args[known[0]]
            if known[1] is not number:
                known[3](self.context, known[2], number)
                # What can change in place is told each time
                known[1] = number if isinstance(number, (int, float, np.generic)) else _nothing
        return True

    def _tell(self, place, array):
        address, shape = memory_of(array)
        # Entries of Taichi's arrays may be vectors, which a kernel knows the size of; it asks for no bytes
        self.context.set_arg_external_array_with_shape((place,), address, max(1, math.prod(shape)), shape, 0)


def _nothing():
    """What a launch was told of an argument before it was told anything."""


def memory_of(array):
    """Address and shape of an array of NumPy's, without gaps, or Taichi's."""
    if isinstance(array, np.ndarray):
        if not array.flags.c_contiguous:
            raise ValueError("a kernel takes arrays without gaps, see numpy.ascontiguousarray")
        return array.__array_interface__["data"][0], array.shape
    return impl.get_runtime().prog.get_ndarray_data_ptr_as_int(array.arr), array.shape
