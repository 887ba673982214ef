"""Cohesion that is lost with plastic strain: a part of the frictional laws.

    c(κ) = c_r + (c₀ − c_r) s(κ),    s(κ) = (exp(−κ/κ_c) − ϵ) / (1 − ϵ) for κ < κ_c ln(1/ϵ), then 0,    ϵ = 1e-6

Exponential decay from the peak to the residual, as in Zabala & Alonso (2011), Géotechnique 61(9), 795-808 (their
η = 1/κ_c).
Deviation: an exponential never reaches zero, and separated material must be known as such, so the last millionth of
the strength is cut off.
"""

from math import log

import numpy as np

from snowmpm.compiler import ti

from .precision import by_precision

CUT = 1e-6
MAX_ITERATIONS = 60
TOLERANCE = (1e-3, 1e-7)  # of the last step, over γ and κ_c: its square is left; the yield surface is met exactly


def strength_left(strain, softening_strain):
    """s(κ), NumPy."""
    decay = np.exp(-np.maximum(strain, 0.0) / softening_strain)
    return np.maximum((decay - CUT) / (1.0 - CUT), 0.0)


def strain_of_loss(softening_strain):
    """κ at which s = 0."""
    return softening_strain * log(1.0 / CUT)


@ti.func
def strength_share(strain, per_strain):
    """s(κ) and −ds/dκ; per_strain: 1/κ_c."""
    share, fall = 0.0, 0.0
    if strain * per_strain < ti.static(log(1.0 / CUT)):
        decay = ti.exp(-strain * per_strain)
        share = ti.max(decay - CUT, 0.0) * ti.static(1.0 / (1.0 - CUT))
        fall = decay * per_strain * ti.static(1.0 / (1.0 - CUT))
    return share, fall


@ti.func
def softening_multiplier(drive, stiffness, loss, strain, per_strain, straight: ti.template()):
    """Root γ > 0 of F(γ) = drive − stiffness γ − loss s(κ + γ), where F(0) > 0, and iterations (−1: not converged).

    s is convex, so F is concave, and with F(0) > 0 it has one root for γ > 0, however steep the softening. The root of
    the fully softened line lies beyond it, and Newton from there comes down to it without ever passing it.
    Without loss that line is the solution: no iteration. straight: −1 for any loss.
    """
    gamma = drive / stiffness
    iterations = 1
    if ti.static(straight):
        iterations = ti.select(loss > 0.0, -1, 1)
    elif loss > 0.0:
        converged = 0
        while converged == 0 and iterations < MAX_ITERATIONS:
            share, fall = strength_share(strain + gamma, per_strain)
            step = ti.min(drive - stiffness * gamma - loss * share, 0.0)
            step /= ti.max(stiffness - loss * fall, ti.static(by_precision(1e-6, 1e-12)) * stiffness)
            tolerance = ti.static(by_precision(*TOLERANCE))
            gamma = ti.max(gamma + step, 0.0)
            iterations += 1
            converged = ti.select(-step <= tolerance * gamma and -step * per_strain <= tolerance, 1, 0)
        iterations = ti.select(converged == 1, iterations, -1)
    return gamma, iterations
