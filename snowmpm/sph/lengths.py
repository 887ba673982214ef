"""Smoothing lengths that follow the particles, and the one length of each pair (Bui & Nguyen 2021, section 2.4).

The rate dh/dt = -(h / d rho) drho/dt (their Eq. 44, after Benz 1990) keeps h^d rho, and so h
over the spacing of the particles. Here that is

    h_i = s_i h,   s_i = (V_i / dx^d)^(1/d)

without a rate to integrate: V is the volume that the particle stands for in sums. The length of a pair is the same seen
from both, since a sum of forces is antisymmetric, and conserves momentum, with symmetric weights alone:

    mean       s = (s_i + s_j) / 2              (45)
    harmonic   s = 2 s_i s_j / (s_i + s_j)      (46, there called geometric); fewer neighbours

    W(r; s) = s^-d W(r / s),   (1/r) dW/dr = s^-(d + 2) (W' / r)(r / s)
"""

import functools
from types import SimpleNamespace
from typing import NamedTuple

from snowmpm.compiler import ti
from snowmpm.sph.row_writing import LARGEST_GROWTH
from snowmpm.sph.smoothing import KERNELS

LEAST = 0.5
"""Of s, in compression; dummies that take no part have no volume at all. The stable step goes with s: waves cross a
shorter length sooner."""


def least(lengths):
    """The least s of a pair."""
    return 1.0 if lengths == "constant" else LEAST


def largest(lengths, dim):
    """The largest s of a pair."""
    return 1.0 if lengths == "constant" else LARGEST_GROWTH ** (1.0 / dim)


class Support(NamedTuple):
    """A smoothing kernel, name of `smoothing.KERNELS`; its radius [cells]; lengths: "constant", "mean" or
    "harmonic"."""

    kernel: str
    radius: float
    lengths: str


@functools.cache
def kernel_functions(support, dim):
    """Taichi functions of a `Support`: own(V) is s of a particle of the volume V [cells], narrowing(s_i, s_j) is
    1 / s of a pair; weight(r, b), slope_over_r(r, b) [cells] with b = 1 / s.

    varies: whether lengths do.
    """
    kernel, radius, lengths = support
    weight_of, slope_of = KERNELS[kernel].functions(radius, dim)
    varies, most = lengths != "constant", largest(lengths, dim)

    @ti.func
    def own(V):
        s = ti.sqrt(V) if ti.static(dim == 2) else ti.pow(V, 1.0 / 3.0)
        return ti.min(ti.max(s, LEAST), most)

    @ti.func
    def narrowing(s_i, s_j):
        b = 2.0 / (s_i + s_j)
        if ti.static(lengths == "harmonic"):
            b = 0.5 / s_i + 0.5 / s_j
        return b

    @ti.func
    def to_dim(b):
        return b * b if ti.static(dim == 2) else b * b * b

    @ti.func
    def weight(r, b):
        return to_dim(b) * weight_of(r * b) if ti.static(varies) else weight_of(r)

    @ti.func
    def slope_over_r(r, b):
        return to_dim(b) * b * b * slope_of(r * b) if ti.static(varies) else slope_of(r)

    return SimpleNamespace(varies=varies, own=own, narrowing=narrowing, weight=weight, slope_over_r=slope_over_r)
