"""Which float a kernel is being compiled for, and constants that depend on it."""

import contextlib

import numpy as np
import taichi as ti
from taichi.lang import impl

DTYPES = {"f32": (ti.f32, np.float32), "f64": (ti.f64, np.float64)}


def by_precision(f32, f64):
    """Pick a constant for the float that the kernel under compilation works in; call it inside `ti.static`."""
    return f32 if impl.get_runtime().default_fp == ti.f32 else f64


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


@contextlib.contextmanager
def working_precision(name):
    """Compile and launch kernels with "f32" or "f64" as the type of literals and of `float`.

    Taichi reads its default float when a kernel is compiled, not when it is started, so one process can serve both.
    Raises RuntimeError when Taichi has not been started: importing a law must never start it.
    """
    runtime = impl.get_runtime()
    if runtime.prog is None:
        raise RuntimeError("Taichi is not running: call snowmpm.runtime.start() first")
    before = runtime.default_fp
    runtime.default_fp = DTYPES[name][0]
    try:
        yield DTYPES[name]
    finally:
        runtime.default_fp = before
