"""The only module that imports the compiler of kernels. All others take `ti` from `snowmpm.compiler`.

Taichi, or where the environment variable SNOWMPM_COMPILER says so, the fork of it that is imported by that name:
`quadrants` or `taichi_forge` (`docs/taichi_forks.md`).
"""

import importlib
import os
from typing import TYPE_CHECKING

from snowmpm.errors import InputError

VARIABLE = "SNOWMPM_COMPILER"
COMPILERS = ("taichi", "quadrants", "taichi_forge")

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
