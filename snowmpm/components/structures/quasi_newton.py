"""Fixed points of two solvers that answer each other, by a multi-vector quasi-Newton method.

With H the answer of one round, r(x) = H(x) - x, and D an approximation of the inverse of dr/dx,

    x_k+1 = x_k - D_k r_k,      D_k = D_0 + (X - D_0 R) (R^T R)^-1 R^T

where the columns of X and R are the changes of x and r in the rounds so far, and D_0 the D that the last step ended
with (A. E. J. Bogaers et al. (2014), doi:10.1016/j.cma.2014.06.033). Plain iterations, D = -1, diverge where what is
held by contact is heavier than what answers; this does not. Where H is linear in m unknowns it ends after m + 1 rounds
at the latest, and after one where D is known from before.
"""

from typing import Any

import numpy as np

ROUNDS = 40
"""At most, in a step. Where snow comes off in the middle of one, 24 were seen."""

TOLERANCE = 1e-5
"""Of r, over the size of the first x, at which the rounds end."""

INDEPENDENT = 1e-8
"""Share of the largest change of r of a round below which what is new in another one counts as none."""

FIRST = 0.1
"""Share of r that the first round ever goes along it: a heavy answer would throw it far off."""


class QuasiNewton:
    """The method, from step to step. inverse: D (m, m), of the last step."""

    def __init__(self, size):
        self.inverse = -FIRST * np.eye(size)

    def solve(self, answer, start, floor):
        """x (m,) with |answer(x) - x| <= TOLERANCE max(|start|, floor), the rounds that it took, and whether it is one.

        answer(x) -> (m,); start (m,): the first x; floor: size of what counts as nothing.
        """
        x, before = np.array(start, float), self.inverse
        enough = TOLERANCE * max(float(np.linalg.norm(x)), floor)
        dx: list[Any] = []
        dr: list[Any] = []
        last, failed, share = None, 0, FIRST
        best, answered, least = x, x, np.inf
        for k in range(ROUNDS):
            r = answer(x) - x
            size = float(np.linalg.norm(r))
            if size <= enough:
                return x, k + 1, True
            if last is not None:
                dx.insert(0, x - last[0])
                dr.insert(0, r - last[1])
                self.inverse = _updated(before, dx, dr)
            last = x, r
            if size < least:
                best, answered, least, failed, share = x, r, size, 0, FIRST
            else:
                failed += 1
            # What went wrong tells how answers change, as well; twice, and it is a matter of how far to go
            if failed < 2:
                x = best - self.inverse @ answered
            else:
                x, share = best + share * answered, 0.5 * share
        return best, ROUNDS, False

    def forget(self):
        """Begin as if nothing was known."""
        self.inverse = -FIRST * np.eye(len(self.inverse))


def _updated(before, dx, dr):
    """D from the changes of this step, newest first; those of r that say nothing new are left out."""
    X, R = np.array(dx[: len(before)]).T, np.array(dr[: len(before)]).T
    Q, T = np.linalg.qr(R)
    size = np.abs(np.diag(T))
    new = size > INDEPENDENT * size.max()
    if not new.any():
        return before
    if not new.all():
        X, R = X[:, new], R[:, new]
        Q, T = np.linalg.qr(R)
    return before + (X - before @ R) @ np.linalg.solve(T, Q.T)
