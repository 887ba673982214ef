"""What knows Taichi's inside: its start, launches, arrays, threads. Nothing else names `taichi`.

Importing it applies the patches to how Taichi reads functions, before any is defined (`snowmpm.compiler.patches`).
"""

from snowmpm.compiler.backend import ti

__all__ = ["ti"]

from snowmpm.compiler import class_bodies, function_trees  # noqa: F401
