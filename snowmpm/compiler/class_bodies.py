"""How Taichi tells a function of a class: by names that Python sets in its body.

Taichi itself reads the line of source that runs, and looks up its module, for each of the hundreds of functions of a
scene. That takes a third of a second of a start (measured).
"""

import sys

from snowmpm.compiler import patches
from snowmpm.compiler.backend import part, ti


def _is_class_body(level_of_class_stackframe):
    # Taichi counts to the frame in which the class is being made; that of its body lies on top of it
    return "__qualname__" in sys._getframe(level_of_class_stackframe - 1).f_locals


def _install():
    kernel_impl = part("lang.kernel_impl")

    patches.replace("class_bodies", kernel_impl, "_inside_class", _is_class_body)

    @ti.func
    def outside(x):
        return x

    class Body:
        @ti.func
        def inside(self, x):
            return x

        @ti.kernel
        def kernel(self):
            pass

    found = outside.func.classfunc, Body.inside.func.classfunc, Body.kernel._is_classkernel
    if found != (False, True, True):
        raise patches.Misfit(f"it takes functions for those of a class as {found}")


patches.apply("class_bodies", _install)
