"""Which float a kernel is being compiled for, and constants that depend on it."""

import numpy as np
import taichi as ti

from .compilation import compiler

DTYPES = {"f32": (ti.f32, np.float32), "f64": (ti.f64, np.float64)}


def by_precision(f32, f64):
    """Pick a constant for the float that the kernel under compilation works in; call it inside `ti.static`."""
    return f32 if compiler().working_float() == ti.f32 else f64


@ti.func
def larger(a, b):
    """Larger of two numbers, b where a is none. One instruction, unlike ti.max, which minds a NaN in b too."""
    return ti.select(a > b, a, b)


@ti.func
def smaller(a, b):
    """Smaller of two numbers, b where a is none."""
    return ti.select(a < b, a, b)


@ti.func
def is_within(x, limit: ti.template()):
    """|x| < limit, false where x is not a number.

    By the bits, since fast floating-point mode may turn a comparison around, and with it what it says of a NaN.
    """
    within = True
    if ti.static(by_precision(True, False)):
        within = ti.bit_cast(ti.cast(ti.abs(x), ti.f32), ti.i32) < ti.bit_cast(ti.cast(limit, ti.f32), ti.i32)
    else:
        within = ti.bit_cast(ti.cast(ti.abs(x), ti.f64), ti.i64) < ti.bit_cast(ti.cast(limit, ti.f64), ti.i64)
    return within


class working_precision:
    """Compile and launch kernels with "f32" or "f64" as the type of literals and of `float`.

    -> Taichi's and NumPy's float. One thread at a time, since Taichi has one default float for all.
    Raises RuntimeError when Taichi has not been started. A class, as `compiling` is: each step enters it several times.
    """

    __slots__ = ("_inner", "_name")

    def __init__(self, name):
        self._name, self._inner = name, compiler().working_precision(DTYPES[name][0])

    def __enter__(self):
        self._inner.__enter__()
        return DTYPES[self._name]

    def __exit__(self, *error):
        self._inner.__exit__(*error)
