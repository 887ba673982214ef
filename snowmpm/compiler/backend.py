"""The only module that imports the compiler of kernels. All others take `ti` from `snowmpm.compiler`.

Taichi, or where the environment variable SNOWMPM_COMPILER says so, the fork of it that is imported by that name:
`quadrants` or `taichi_forge` (`docs/taichi_forks.md`).
"""

import contextlib
import importlib
import inspect
import linecache
import os
from typing import TYPE_CHECKING

from snowmpm.compiler import patches
from snowmpm.errors import InputError

VARIABLE = "SNOWMPM_COMPILER"
COMPILERS = ("taichi", "quadrants", "taichi_forge")


@contextlib.contextmanager
def _short_looks():
    """Context: who asks where a frame is gets its line of source, and no search through all modules. Taichi asks for
    each function of its own while it is imported, 0.1 s of a start (measured): part of the patch `class_bodies`."""
    kept = inspect.getframeinfo
    if patches.wanted("class_bodies"):
        inspect.getframeinfo = lambda frame, context=1: inspect.Traceback(
            frame.f_code.co_filename, frame.f_lineno, frame.f_code.co_name,
            [linecache.getline(frame.f_code.co_filename, frame.f_lineno)], 0)
    try:
        yield
    finally:
        inspect.getframeinfo = kept


chosen = os.environ.get(VARIABLE) or COMPILERS[0]
if chosen not in COMPILERS:
    raise InputError(f"{VARIABLE}={chosen}: must be one of {', '.join(COMPILERS)}")
if TYPE_CHECKING:
    import taichi as ti
    from taichi.lang import impl
else:
    level = os.environ.get("TI_LOG_LEVEL")
    os.environ["TI_LOG_LEVEL"] = level or "warn"  # it would greet a notebook: "Graphical python shell detected"
    try:
        with _short_looks():
            ti = importlib.import_module(chosen)
    except ModuleNotFoundError as error:
        if chosen == COMPILERS[0] or error.name != chosen:
            raise
        raise InputError(f"{VARIABLE}={chosen}: is not installed; pip install {chosen.replace('_', '-')}") from None
    finally:
        if level is None:
            del os.environ["TI_LOG_LEVEL"]
    impl = importlib.import_module(f"{chosen}.lang.impl")

__all__ = ["impl", "part", "ti"]


def part(name):
    """Module of the compiler's inside, such as "lang.matrix". Raises ImportError where it has none of that name."""
    return importlib.import_module(f"{ti.__name__}.{name}")
