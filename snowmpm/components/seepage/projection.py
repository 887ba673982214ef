"""The pressure that keeps water from taking more room than there is.

    f' = f + dt G w',   w' = b (w + dt g) - dt b / m G^T l,   l_i = p_i V_i / n_i
    p >= 0,   f' <= 1 + p / K,   p (f' - 1 - p / K) = 0

G: the gradients of `fullness`, b = 1 / (1 + dt C / (n rho)) of the drag coefficient C, implicit in the speed, m:
masses. Water is pressed, and never pulled: where it parts, as at its surface, nothing has to say so (as in Ihmsen et
al. 2014, doi:10.1109/TVCG.2013.105). G and its transpose make the forces of water on water, on grains and on walls
opposite to each other, and the equations symmetric and positive: SciPy's conjugate gradients, over the particles that
are pressed,
until these are known. K, the stiffness of the water, also settles what the kernel is too smooth to tell.
"""

import numpy as np
from scipy.sparse.linalg import LinearOperator, cg

TOLERANCE = 1e-4
"""Of the residual, over the right side."""

ROUNDS = 8
"""Searches of who is pressed; what is left then is pulled nowhere, and is mended in the next step."""

PASSES = 500


class Unsolved(ArithmeticError):
    """Conjugate gradients that did not settle."""


def pressed(gradients, answer, compliance, excess, start):
    """l (n,) >= 0 [Pa m3] with excess - A l <= 0, and 0 where l > 0; A = compliance + sum G answer G^T over the axes,
    answer (n,): dt² b / m [m²/ (Pa m3)]. start (n,): a guess. -> l, passes. Raises Unsolved."""
    transposed = [G.T.tocsr() for G in gradients]
    diagonal = compliance + sum(G.multiply(G) @ answer for G in gradients)
    load, passes = np.maximum(start, 0.0), 0
    active = (excess > 0.0) | (load > 0.0)

    def applied(values):
        out = compliance * values
        for G, back in zip(gradients, transposed, strict=True):
            out = out + G @ (answer * (back @ values))
        return out

    def count(_):
        nonlocal passes
        passes += 1

    n = len(excess)
    for _ in range(ROUNDS):
        held = active

        def within(values, held=held):
            return np.where(held, applied(np.where(held, values, 0.0)), values)

        found, failed = cg(LinearOperator((n, n), within, dtype=float), np.where(held, excess, 0.0),
                           np.where(held, load, 0.0), rtol=TOLERANCE, maxiter=PASSES, callback=count,
                           M=LinearOperator((n, n), lambda values, held=held: values / np.where(held, diagonal, 1.0),
                                            dtype=float))
        if failed:
            raise Unsolved(passes)
        load = np.where(held, found, 0.0)
        left = excess - applied(np.maximum(load, 0.0))
        active = (held & (load > 0.0)) | (~held & (left > TOLERANCE * np.abs(excess).max(initial=0.0)))
        if (active == held).all():
            break
    return np.where(held, np.maximum(load, 0.0), 0.0), passes
