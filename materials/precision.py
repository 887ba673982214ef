"""Which float a kernel is being compiled for, and constants that depend on it."""

from snowmpm.compiler import ti
from snowmpm.compiler.settings import DTYPES, working_float, working_precision

__all__ = ["DTYPES", "by_precision", "is_within", "larger", "smaller", "working_precision"]


def by_precision(f32, f64):
    """Pick a constant for the float that the kernel under compilation works in; call it inside `ti.static`."""
    return f32 if working_float() == ti.f32 else f64


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
