"""Power series of functions of one number, in a straight line: no branch, no call of a library.

Each holds for small arguments, keeps relative accuracy there, and has as many terms as its float needs. The rounding of
a term waits for that of the one before, so long series are summed in two halves that do not wait for each other.
"""

from math import factorial

import numpy as np

from snowmpm.compiler import ti

from .precision import by_precision

ARTANH = tuple(1.0 / (2 * k + 1) for k in range(7))
LOG1P = tuple((-1) ** k / (k + 1) for k in range(6))
EXP = tuple(1.0 / factorial(k) for k in range(14))
EXPM1 = EXP[1:11]
SINH = tuple(1.0 / factorial(2 * k + 1) for k in range(7))
COSH = tuple(1.0 / factorial(2 * k) for k in range(6))

SMALL_LOG = 0.15
SMALL_ARTANH = 0.0815  # the argument that `log1p_series` of −SMALL_LOG has
SMALL_EXP = 0.155
SMALL_SINH = 0.5


@ti.func
def power_series(x, coefficients: ti.template(), first: ti.template(), f32: ti.template(), f64: ti.template()):
    """Σ c_k x^(k − first) over k = first, first + 1, …, as many terms as the float needs."""
    last = ti.static(first + by_precision(f32, f64) - 1)
    total = 0.0 * x + ti.static(coefficients[last])
    if ti.static(last - first < 4):
        for k in ti.static(range(last - 1, first - 1, -1)):
            total = total * x + ti.static(coefficients[k])
    else:
        x2, other = x * x, 0.0 * x + ti.static(coefficients[last - 1])
        for k in ti.static(range(last - 2, first - 1, -2)):
            total = total * x2 + ti.static(coefficients[k])
        for k in ti.static(range(last - 3, first - 1, -2)):
            other = other * x2 + ti.static(coefficients[k])
        total = total * x + other if ti.static((last - first) % 2 == 1) else other * x + total
    return total


@ti.func
def artanh_ratio(x2):
    """artanh(x) / x of x², |x| < SMALL_ARTANH."""
    return power_series(x2, ARTANH, 0, 3, 7)


@ti.func
def log1p_series(x):
    """ln(1 + x) for |x| < SMALL_LOG: 2 artanh(x / (2 + x))."""
    t = x / (2.0 + x)
    return 2.0 * t * artanh_ratio(t * t)


@ti.func
def log1p_of_square(x2):
    """ln(1 − x²), |x| < SMALL_ARTANH; x² is small beside what it is added to."""
    return -x2 * power_series(-x2, LOG1P, 0, 3, 6)


@ti.func
def expm1_series(x):
    """exp(x) − 1 for |x| < SMALL_EXP."""
    return x * power_series(x, EXPM1, 0, 6, 10)


@ti.func
def sinh_ratio(x2):
    """sinh(x) / x of x², |x| < SMALL_EXP."""
    return power_series(x2, SINH, 0, 3, 5)


@ti.func
def coshm1_of_square(x2):
    """cosh(x) − 1 of x², |x| < SMALL_EXP."""
    return x2 * power_series(x2, COSH, 1, 2, 5)


@ti.func
def sinh_series(x):
    """sinh(x), |x| < SMALL_SINH."""
    return x * power_series(x * x, SINH, 0, 4, 7)


@ti.func
def straight_exp(x):
    """exp(x) = 2^n exp(r), x = n ln 2 + r, the first factor by its bits.

    Relative error |x| times round-off, as of x itself; |x| < 80 (float32) or 700 (float64).
    """
    n = ti.floor(x * ti.static(1.0 / np.log(2.0)) + 0.5)
    r = x - n * ti.static(np.log(2.0))
    power = 1.0
    if ti.static(by_precision(True, False)):
        power = ti.bit_cast((ti.cast(n, ti.i32) + 127) << 23, ti.f32)
    else:
        power = ti.bit_cast(ti.cast(ti.cast(n, ti.i32) + 1023, ti.i64) << 52, ti.f64)
    return power_series(r, EXP, 0, 8, 14) * power
