"""Finite-strain kinematics of an isotropic law: from the stored tensor to the Hencky strain and back.

    b = Fe Feᵀ,   h = b − I (stored),   ε = ½ ln b (Hencky strain)

h, not b, is stored and updated, so that 1 + small is never formed and float32 keeps strains of 1e-6.
Near the identity, ln and exp of a traceless tensor X are polynomials in X; by Cayley-Hamilton
X³ = j₂ X + j₃ I (j₂ = ½ tr X², j₃ = det X), so they reduce to two coefficients, with no eigenvectors and no divisions.
Far from it ln takes the spectral path of `spectral.py`, exp is scaled and squared. The choice is made per particle.
"""

from math import factorial

import taichi as ti

from .precision import by_precision
from .spectral import eigen
from .symmetric import (
    PAIRS,
    add_symmetric_part,
    contract,
    determinant,
    plus_isotropic,
    product_in_space,
    squared,
    trace,
)

# Order of the series and the Frobenius norm up to which it is right to round-off:
# the first term left out, norm^order / (order + 1) relative to X for ln, norm^order / (order + 1)! for exp.
LOG_ORDER = (6, 12)  # float32, float64
LOG_RADIUS = (0.1, 0.06)
EXP_ORDER = (6, 10)
EXP_RADIUS = (0.3, 0.15)
MAX_HALVINGS = 12


@ti.func
def log1p(x):
    """ln(1 + x), relative accuracy kept for small x."""
    result = 0.0
    if ti.abs(x) < 0.25:
        # 2 artanh(x / (2 + x)); |argument| < 1/7
        t = x / (2.0 + x)
        u = t * t
        poly = 0.0
        for k in ti.static(range(by_precision(4, 9), 0, -1)):
            poly = poly * u + ti.static(1.0 / (2 * k + 1))
        result = 2.0 * t * (1.0 + u * poly)
    else:
        result = ti.log(1.0 + x)
    return result


@ti.func
def expm1(x):
    """exp(x) − 1, relative accuracy kept for small x."""
    result = 0.0
    if ti.abs(x) < 0.3:
        poly = 1.0
        for k in ti.static(range(by_precision(7, 13), 1, -1)):
            poly = 1.0 + poly * x * ti.static(1.0 / k)
        result = poly * x
    else:
        result = ti.exp(x) - 1.0
    return result


@ti.func
def trial_deviation(h, A):
    """h of the trial state f b fᵀ with f = I + A:  h + A + Aᵀ + A Aᵀ + A h + h Aᵀ + A h Aᵀ.

    A: dim × dim, out-of-plane stretch 1 in plane strain.
    """
    return add_symmetric_part(h, A + product_in_space(A, h), A)


@ti.func
def _log_spectral(h):
    """(deviator of ½ ln(I + h), trace) by eigen-decomposition.

    Entries of b carry round-off of the largest one, so an eigenvalue below that is noise, maybe negative: it is
    lifted to that round-off (only reached by principal stretches that differ by 1e3 in float32, 1e7 in float64).
    """
    w, V = eigen(h)
    floor = ti.static(by_precision(6e-8, 1e-16)) * (1.0 + ti.abs(w).max())
    e = ti.Vector([0.0, 0.0, 0.0])
    for i in ti.static(range(3)):
        e[i] = 0.5 * log1p(ti.max(w[i], floor - 1.0))
    volume = e.sum()
    e -= volume / 3.0
    deviator = h
    for k in ti.static(range(h.n)):
        i, j = ti.static(PAIRS[k])
        deviator[k] = V[i, 0] * V[j, 0] * e[0] + V[i, 1] * V[j, 1] * e[1] + V[i, 2] * V[j, 2] * e[2]
    return deviator, volume


@ti.func
def hencky_strain(h):
    """Deviator and trace of ε = ½ ln(I + h)."""
    mean = trace(h) / 3.0
    scale = 1.0 + mean
    X = plus_isotropic(h, -mean) / scale
    j2 = 0.5 * contract(X, X)
    j3 = determinant(X)
    # det(I + h) − 1, every term small when h is
    det_less_one = mean * (3.0 + mean * (3.0 + mean)) + scale * scale * scale * (j3 - j2)
    deviator = X
    volume = 0.0
    if 2.0 * j2 < ti.static(by_precision(*LOG_RADIUS) ** 2) and ti.abs(det_less_one) < 0.25 and scale > 0.5:
        volume = 0.5 * log1p(det_less_one)
        # ln(I + X) = Σ (−1)^(k+1) X^k / k;  X^k = c0 I + c1 X + c2 X²
        a1, a2 = 0.5, -0.25
        c0, c1, c2 = 0.0, 0.0, 1.0
        for k in ti.static(range(3, by_precision(*LOG_ORDER) + 1)):
            c0, c1, c2 = c2 * j3, c0 + c2 * j2, c1
            a1 += ti.static((-1) ** (k + 1) * 0.5 / k) * c1
            a2 += ti.static((-1) ** (k + 1) * 0.5 / k) * c2
        deviator = plus_isotropic(a1 * X + a2 * squared(X), -a2 * j2 * ti.static(2.0 / 3.0))
    else:
        deviator, volume = _log_spectral(h)
    return deviator, volume


@ti.func
def _exp_series(X):
    """exp(X) − I of a traceless X within EXP_RADIUS."""
    j2 = 0.5 * contract(X, X)
    j3 = determinant(X)
    a0, a1, a2 = 0.0, 1.0, 0.5
    c0, c1, c2 = 0.0, 0.0, 1.0
    for k in ti.static(range(3, by_precision(*EXP_ORDER) + 1)):
        c0, c1, c2 = c2 * j3, c0 + c2 * j2, c1
        a0 += ti.static(1.0 / factorial(k)) * c0
        a1 += ti.static(1.0 / factorial(k)) * c1
        a2 += ti.static(1.0 / factorial(k)) * c2
    return plus_isotropic(a1 * X + a2 * squared(X), a0)


@ti.func
def deviation_of_strain(deviator, volume):
    """h = exp(2 ε) − I of the Hencky strain with the given deviator and trace."""
    X = 2.0 * deviator
    norm2 = contract(X, X)
    halvings = 0
    scale = 1.0
    while norm2 > ti.static(by_precision(*EXP_RADIUS) ** 2) and halvings < MAX_HALVINGS:
        norm2 *= 0.25
        scale *= 0.5
        halvings += 1
    Y = _exp_series(X * scale)
    for _ in range(halvings):
        Y = 2.0 * Y + squared(Y)
    growth = expm1(ti.static(2.0 / 3.0) * volume)
    return plus_isotropic((1.0 + growth) * Y, growth)
