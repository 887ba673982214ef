"""How Taichi tells a function of a class: by names that Python sets in its body. Import this before any is decorated.

It reads the line of source that runs instead, and looks up whose module that is, for each of the hundreds of functions
of a scene: a third of a second of a start (measured).
"""

import sys

from taichi.lang import kernel_impl


def _is_class_body(level_of_class_stackframe):
    # Taichi counts to the frame in which the class is being made; that of its body lies on top of it
    return "__qualname__" in sys._getframe(level_of_class_stackframe - 1).f_locals


kernel_impl._inside_class = _is_class_body
