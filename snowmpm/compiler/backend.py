"""The only module that imports the compiler of kernels: Taichi. All others take `ti` from `snowmpm.compiler`."""

import importlib

import taichi as ti
from taichi.lang import impl

__all__ = ["impl", "part", "ti"]


def part(name):
    """Module of Taichi's inside, such as "lang.matrix". Raises ImportError where this Taichi has none of that name."""
    return importlib.import_module(f"{ti.__name__}.{name}")
