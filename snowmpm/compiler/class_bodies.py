"""How Taichi tells a function of a class: by names that Python sets in its body.

Taichi itself reads the line of source that runs, and looks up its module, for each of the hundreds of functions of a
scene. That takes a third of a second of a start (measured).
"""

import sys

from snowmpm.compiler import patches


def _is_class_body(level_of_class_stackframe):
    # Taichi counts to the frame in which the class is being made; that of its body lies on top of it
    return "__qualname__" in sys._getframe(level_of_class_stackframe - 1).f_locals


def _install():
    from taichi.lang import kernel_impl

    kernel_impl._inside_class  # noqa: B018 (a name that is gone would be set without effect)
    kernel_impl._inside_class = _is_class_body


patches.apply("class_bodies", _install)
