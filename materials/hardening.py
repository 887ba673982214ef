"""How the size p₀ of a yield surface follows its hardening variable ζ: one formula, three laws.

    p₀ = p_fixed + S v(ξ ζ),      dv/dt = √(o + v²),   d²v/dt² = v

    sinh         v = sinh(max(t, 0)), S = K, o = 1     snow: no strength left at ζ = 0, where grains part
    exponential  v = exp(t),          S = p₀(0), o = 0   clay, and the limit of sinh when compacted far
    none         p₀ = p_fixed                          perfect plasticity

Numbers, not code, tell the three apart, so one compiled return map serves all.
"""

from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np
from numpy.typing import ArrayLike
from pydantic import AfterValidator

from snowmpm.compiler import ti

from .arrays import Array
from .law import NonNegative
from .precision import by_precision, is_within, larger, smaller
from .series import SMALL_EXP, SMALL_SINH, coshm1_of_square, sinh_ratio, sinh_series, straight_exp

LEAST_RATE = 1e-4
"""Smallest ξ that is not 0: ζ₀ = asinh(p₀/K)/ξ must stay a number to calculate with."""


def _none_or_enough(rate):
    if 0.0 < rate < LEAST_RATE:
        raise ValueError(f"must be 0 (perfect plasticity) or at least {LEAST_RATE}")
    return rate


HardeningKind = Literal["sinh", "exponential"]
HardeningRate = Annotated[NonNegative, AfterValidator(_none_or_enough)]

FAINTEST = 20.0
"""−t at which exponential hardening counts as gone: e^−20 = 2e-9 of the initial strength."""


LARGEST = (1e12, 1e100)
"""What v is limited to: beyond any use, and its square is still a number."""


@ti.func
def hardening_value(t, o, straight: ti.template()):
    """v(t). sinh keeps its relative accuracy for small t; v <= LARGEST.

    straight: "sinh" or "exponential", that kind alone (o tells both apart) without a branch or a library, and right
    only where `in_reach`; or "".
    """
    v = 1.0
    if ti.static(straight == "sinh"):
        v = sinh_series(larger(t, 0.0))
    elif ti.static(straight == "exponential"):
        v = straight_exp(smaller(larger(t, -FAINTEST), ti.static(np.log(by_precision(*LARGEST)))))
    elif o > 0.0:
        t = larger(t, 0.0)
        if t < SMALL_SINH:
            v = sinh_series(t)
        else:
            e = ti.exp(t)
            v = smaller(0.5 * (e - 1.0 / e), ti.static(by_precision(*LARGEST)))
    else:
        v = smaller(ti.exp(larger(t, -FAINTEST)), ti.static(by_precision(*LARGEST)))
    return v


@ti.func
def hardening_slope(v, o):
    """dv/dt"""
    return ti.sqrt(o + v * v)


@ti.func
def hardening_moved(v, slope, s):
    """v and dv/dt at t + s from those at t, and whether s is small enough for them to be right.

    v'' = v, so that v(t + s) = v cosh s + v' sinh s for every kind: cheaper than v of another argument.
    """
    s2 = s * s
    c, d = coshm1_of_square(s2), s * sinh_ratio(s2)
    return v + (v * c + slope * d), slope + (v * d + slope * c), is_within(s, SMALL_EXP)


@ti.func
def in_reach(t, o):
    """Whether the straight form of `hardening_value` is right at t."""
    return t * o < SMALL_SINH


@dataclass(frozen=True)
class Hardening:
    """p₀(ζ) of one material: `fixed` p_fixed [Pa], `scale` S [Pa], `offset` o, `rate` ξ, `start` ζ at the initial p₀,
    `end` ζ at which the strength is gone (−∞ if never)."""

    fixed: float
    scale: float
    offset: float
    rate: float
    start: float
    end: float

    @classmethod
    def of(cls, kind: str, bulk_modulus: float, rate: float, p0: float) -> "Hardening":
        """The part that a law's parameters ask for: kind "sinh" or "exponential"; rate ξ = 0 is none."""
        if rate == 0.0:
            return cls(fixed=p0, scale=0.0, offset=1.0, rate=0.0, start=0.0, end=-np.inf)
        if kind == "exponential":
            return cls(fixed=0.0, scale=p0, offset=0.0, rate=rate, start=0.0, end=-FAINTEST / rate)
        start = float(np.arcsinh(p0 / bulk_modulus) / rate)
        return cls(fixed=0.0, scale=bulk_modulus, offset=1.0, rate=rate, start=start, end=0.0)

    def p0(self, zeta: ArrayLike) -> Array:
        """p₀ [Pa] at ζ. NumPy."""
        t = self.rate * np.asarray(zeta, float)
        v = np.sinh(np.maximum(t, 0.0)) if self.offset else np.exp(np.maximum(t, -FAINTEST))
        return self.fixed + self.scale * v
