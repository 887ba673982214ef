"""Launching kernels at little cost.

Before each launch Taichi compares every argument with every kind of argument it knows: 60 to 90 us for the 8 to 18 of
a kernel here, as long as a thousand particles take in 2-D (measured). But what a kernel takes is known when it is
defined, numbers and arrays, and what the arrays hold seldom changes from one launch to the next.

This is the patch `launch` (`snowmpm.compiler.patches`): without it kernels are Taichi's own.
"""

import contextlib
import copy
import functools
import gc
import operator
import types
from types import SimpleNamespace

import numpy as np

from snowmpm.compiler import front_end, lifetime, patches, relaunch
from snowmpm.compiler.backend import impl, ti


def taichi_kernel(function, plain=False):
    """`ti.kernel`, by a `Launcher` if the function takes numbers and arrays only and returns nothing. plain: by
    `plain_compilation`."""
    kernel = ti.kernel(function)
    if patches.apply("launch", _look):
        setters = [_setter(argument.annotation) for argument in kernel._primal.arguments]
        if None not in setters and kernel._primal.return_type is None:
            return functools.wraps(function)(Launcher(kernel, setters, plain))
    return plain_compilation()(kernel) if plain else kernel


@contextlib.contextmanager
def plain_compilation():
    """Compile and launch kernels without Taichi's own optimiser, leaving the work to LLVM's.

    Its passes take time with the square of the accesses to local arrays: 17 s instead of 2.5 s for a kernel that works
    on packs of particles (measured), for code as fast. Small kernels are faster with it. The setting is part of the key
    of a compiled kernel, so it must be the same at every launch. It is no patch and has no switch: SPH rounds otherwise
    with Taichi's passes.
    """
    config = impl.current_cfg()
    before = config.advanced_optimization
    config.advanced_optimization = False
    try:
        yield
    finally:
        config.advanced_optimization = before


def own_launches(kernel):
    """The same kernel, compiled once, for one of several who launch it in turn, each with arguments of its own: so it
    is told what changed since its owner's last launch."""
    if isinstance(kernel, types.FunctionType) and "of_groups" in vars(kernel):
        flat, single = kernel.of_groups
        return grouped(own_launches(flat), single)
    if not isinstance(kernel, Launcher):
        return kernel
    own = copy.copy(kernel)
    own._again = None
    return own


def _look():
    """Look for all that a `Launcher` uses of a kernel before it is compiled."""

    @ti.kernel
    def nothing(values: ti.types.ndarray(), number: ti.f64):
        for i in range(1):
            values[i] = number

    inner = nothing._primal
    inner.arguments[0].annotation, inner.return_type, inner.ensure_compiled
    types = ti.types.primitive_types
    types.real_type_ids, types.integer_type_ids, ti.types.ndarray_type.NdarrayType  # noqa: B018


class Launcher:
    """A kernel, and what Taichi compiled of it by what its arrays hold.

    Arrays are Taichi's or NumPy's, the latter of numbers only and without gaps. Raises TypeError for a number that is
    none, EndedError for an array of a Taichi that was ended, and what Taichi raises for one that the kernel does not
    take.
    """

    def __init__(self, kernel, setters, plain=False):
        self._plain, self._kernel = plain_compilation()(kernel) if plain else kernel, kernel._primal
        self._around = plain_compilation if plain else contextlib.nullcontext
        self._setters = [((i,), setter) for i, setter in enumerate(setters)]
        self._arrays = [i for i, setter in enumerate(setters) if setter is _set_array]
        self._start, self._compiled, self._again = None, {}, None

    def __call__(self, *args):
        if not patches.is_applied("launch"):
            return self._plain(*args)
        start = impl.get_runtime()
        runs = self._start is start and start.prog is not None
        again = self._again if runs else None
        if again is None or not again.take(args, _kind):
            key = tuple([_kind(args[i]) for i in self._arrays])
            if not (runs and key in self._compiled):
                with self._around():
                    compiled = self._compile(key, args)
                if not compiled:
                    return self._plain(*args)
            again = self._told(key, args)
        try:
            start.prog.launch_kernel(again.code, again.context)
        except TypeError as error:  # of another Taichi, whose compiled kernels are launched in another way
            patches.leave_out("launch", error)
            return self._plain(*args)
        return None

    def _told(self, key, args):
        """A launch that has been told all arguments."""
        kernel, code = self._compiled[key]
        context = kernel.make_launch_context()
        if self._stays:
            again = relaunch.Relaunch(code, context, dict(zip(self._arrays, key, strict=True)), self._setters)
            if again.take(args, _kind):
                self._again = again
                return again
        for (place, setter), value in zip(self._setters, args, strict=True):
            setter(context, place, value)
        return SimpleNamespace(code=code, context=context)

    def _compile(self, key, args):
        """Compile for the kinds of these arguments; -> whether what was compiled is where it is looked for."""
        start = impl.get_runtime()
        for i in self._arrays:
            if not isinstance(args[i], np.ndarray):
                lifetime.check(lifetime.start_of(args[i]), "this array")
        lifetime.check(start, "this kernel")
        if self._start is not start:
            self._start, self._compiled, self._again = start, {}, None
            self._stays = relaunch.applied(start)
        with _no_collection():
            kernel, code = front_end.compiled(self._kernel, args)
        try:
            kernel.make_launch_context  # noqa: B018
        except patches.MISFITS as error:
            patches.leave_out("launch", error)
            return False
        self._compiled[key] = kernel, code
        return True


def grouped(kernel, single):
    """A kernel that takes its arguments in groups (`compiler.groups`); single: whether each is a group or not.

    Written out, `lambda kernel: lambda a, b: kernel(*a, b)`: a loop over the groups would take as long as a launch.
    """
    launch = _grouped(tuple(single))(kernel)
    launch.of_groups = kernel, single
    return launch


@functools.cache
def _grouped(single):
    names = [f"a{i}" for i in range(len(single))]
    parts = [name if alone else f"*{name}" for name, alone in zip(names, single, strict=True)]
    return eval(f"lambda kernel: lambda {', '.join(names)}: kernel({', '.join(parts)})")


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
    """What an array holds, its number of axes, and to which start of Taichi it belongs."""
    if isinstance(array, np.ndarray):
        return array.dtype.num, array.ndim
    try:
        return array.kind_of_argument
    except AttributeError:
        array.kind_of_argument = array.element_type, len(array.shape), id(lifetime.start_of(array))
        return array.kind_of_argument


def _setter(annotation):
    if isinstance(annotation, ti.types.ndarray_type.NdarrayType):
        return _set_array
    if id(annotation) in ti.types.primitive_types.real_type_ids:
        return _set_real
    if id(annotation) in ti.types.primitive_types.integer_type_ids:
        return _set_integer
    return None


def _set_real(context, place, value):
    context.set_arg_float(place, float(value))


def _set_integer(context, place, value):
    context.set_arg_int(place, operator.index(value))


def _set_array(context, place, array):
    if isinstance(array, np.ndarray):
        address, shape = relaunch.memory_of(array)
        context.set_arg_external_array_with_shape(place, address, array.nbytes, shape, 0)
    else:
        context.set_arg_ndarray(place, array.arr)
