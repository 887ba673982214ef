"""To which start of Taichi things belong.

`ti.init` and `ti.reset` end the Taichi that runs and, without a word, every array in it: Taichi itself then reads and
frees memory that is something else's. Each start has a Python object of its own, `impl.get_runtime()`, by which arrays
and simulations here know theirs.
"""

import ctypes
import functools
import threading
from collections.abc import Callable
from typing import Any, TypeVar

from snowmpm.compiler import patches
from snowmpm.compiler.backend import impl, part, ti
from snowmpm.compiler.settings import compiling, runs
from snowmpm.errors import EndedError

F = TypeVar("F", bound=Callable[..., Any])

SPAWN = 'use multiprocessing.get_context("spawn")'

_left, _ended = [], []
"""Starts of Taichi in processes that this one was forked from, with their programs; those of them that were ended."""


def watch_arrays():
    """Let arrays know to which start of Taichi they belong, and give their memory back to it alone.

    Taichi 1.7 keeps those of vectors and matrices to the end of the program, and a grid that grows with the avalanche
    makes new ones again and again; those of numbers it frees by an address that may be another array's by then.

    This is the patch `array_lifetime`. Without it an array is not known to have ended with its Taichi.
    """
    patches.apply("array_lifetime", _install)


def _install():
    matrix = part("lang.matrix")

    impl._ti_core.Program.delete_ndarray  # noqa: B018 (used later: it must be there)
    make, replace = ti.Ndarray.__init__, functools.partial(patches.replace, "array_lifetime")

    def made(array):
        make(array)
        array._start = impl.get_runtime()

    replace(ti.Ndarray, "_start", impl.get_runtime(), new=True)  # of arrays that were there before
    replace(ti.Ndarray, "__init__", made)
    for kind in (ti.ScalarNdarray, matrix.VectorNdarray, matrix.MatrixNdarray):
        replace(kind, "__del__", _free, new=True)


def _free(array):
    # At the end of Python its modules may be gone before its arrays
    runtime = impl.get_runtime() if impl is not None and impl.get_runtime is not None else None
    if runtime is not None and runtime.prog is not None and array._start is runtime and array.arr is not None:
        runtime.prog.delete_ndarray(array.arr)


def start_of(array):
    """The start of Taichi that an array belongs to; without the patch, the one that runs."""
    return getattr(array, "_start", None) or impl.get_runtime()


def current():
    """The start of Taichi that runs, by which what is made now knows its own."""
    return impl.get_runtime()


def check(start, what="this simulation"):
    """Raises EndedError unless this start of Taichi still runs, in this process."""
    if start is impl.get_runtime() and runs(start):
        return
    if any(start is runtime for runtime, *_ in _left):
        raise EndedError(f"{what} belongs to the process that this one was forked from, whose threads are not here:\n"
                         "make another one here, from its scene or a checkpoint")
    raise EndedError(f"{what} ended with the Taichi that it ran in (ti.init or ti.reset since);\nmake another one, from"
                     " its scene or a checkpoint")


def in_turn(method: F) -> F:
    """The method, in one thread at a time, and only in the Taichi that its object was made in (`_start`)."""

    @functools.wraps(method)
    def call(self, *args, **options):
        with compiling():
            check(self._start)
            return method(self, *args, **options)

    return call


def part_after_fork(thread):
    """In a forked process: leave the parent's Taichi alone. To wait for its threads, or to end them, takes for ever.

    thread: identity of the thread that started it.
    """
    runtime = impl.get_runtime()
    ctypes.pythonapi.Py_IncRef(ctypes.py_object(runtime.prog))  # where it is freed, it is ended
    _left.append((runtime, runtime.prog, thread))
    runtime.prog = None


def end_parents():
    """In a forked process: let Taichi be started once more. Raises EndedError where it cannot be."""
    for runtime, program, thread in _left:
        if runtime in _ended:
            continue
        if program.config().arch == impl._ti_core.Arch.cuda:
            raise EndedError("CUDA cannot be used in a process that was forked from one that used it;\n" + SPAWN)
        if thread != threading.get_ident():  # which alone may end it; any other would wait for ever
            raise EndedError("Taichi cannot be started again in a process that was forked by another thread than the"
                             f" one that started it;\n{SPAWN}")
        program.finalize()
        _ended.append(runtime)
