"""What knows Taichi's inside: its start, launches, arrays, threads. Nothing else names `taichi.lang`.

Importing it applies the patches to how Taichi reads functions, before any is defined (`snowmpm.compiler.patches`), and
gives the laws what they ask of the compiler.
"""

from snowmpm.compiler import class_bodies, function_trees  # noqa: F401, I001
from snowmpm.compiler import settings  # noqa: F401
