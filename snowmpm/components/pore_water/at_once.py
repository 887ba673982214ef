"""Skeleton and pore water of an implicit step, solved at once or in turn.

At once ("monolithic"), unknowns are the displacements and, of each cell, y = p / e:

    [ T^T K T     -e (Q T)^T ] [dv]     [ T^T R ]         Q = dP/du: sum_p V J f^-T g over the particles of a cell
    [ -e Q T      -e^2 dr/dp ] [dy] = - [ -e r  ]

In turn ("fixed_stress", Kim 2010; White, Castelletto & Tchelepi 2016, doi:10.1016/j.cma.2016.01.008): the flow with the
skeleton's answer at fixed stress, alpha M dp, M the volume of a cell, and then the skeleton under the new pressure,

    (dr/dp + alpha M) dp = -r,    R(u, p + dp) = 0,

until |r| has fallen to the tolerance. alpha = 1 / K_dr: without inertia it settles for any step and fluid where alpha
is at least half of the true one; that of confined compression, 1 / E_oed, is exact in one dimension. With inertia the
skeleton answers less than that, and it is slow (Nøst 2019, section 6.5).
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import sparse

from snowmpm.implicit.kernel_api import ROUND_OFF, Balance, NotConverged, Solved, solve, turned

FLED = 1e3
"""Times the first residual, beyond which passes lead away."""


@dataclass
class Both:
    """What holds displacements and pressures: T of `held.Held`, and the cells' own."""

    held: Any
    n_cells: int

    def __post_init__(self):
        self.T = sparse.block_diag([self.held.T, sparse.eye_array(self.n_cells)], format="csr")
        self.touched = self.held.touched

    def full(self, x):
        """u (N, dim) of [v, y]."""
        return self.held.full(x[: len(x) - self.n_cells])

    def reduced(self, f):
        """T^T f of nodal forces (N, dim), of the displacements alone."""
        return self.held.reduced(f)


class AtOnce(Balance):
    """Equations of [v, y]. pores: `Pores`; unit: e [Pa/m]."""

    def __init__(self, pores, unit, mesh, held, *rest):
        super().__init__(mesh, Both(held, len(pores.cells)), *rest)
        self._around, self.pores, self._unit = self.pull, pores, unit

    def pressure(self, x):
        """p (cells,) [Pa] of [v, y]."""
        return self._unit * x[len(x) - len(self.pores.cells) :]

    def at(self, x, tangents=False):
        """`Trial` at [v, y]."""
        p = self.pressure(x)
        self.pull = pull_of(self._around, self.pores, p)
        trial = super().at(x, tangents)
        left = self._unit * self.pores.residual(p, trial.after.ratio)
        trial.free = np.concatenate([trial.free, -left])
        trial.noise += ROUND_OFF * self._unit * float(np.linalg.norm(self.pores.content))
        trial.sound = trial.sound and bool(np.isfinite(left).all())
        return trial

    def matrix(self, trial):
        """The matrix above before T, (dim N + cells, dim N + cells)."""
        e, ratio = self._unit, trial.after.ratio
        Q = -e * growth_of_cells(self.mesh, self.pores.cells, self.volume, trial)
        return sparse.block_array([[super().matrix(trial), Q.T], [Q, -(e**2) * self.pores.matrix(ratio)]], format="csr")


def growth_of_cells(mesh, cells, volume, trial):
    """Q (cells, dim N) [m2]: how the volume of each cell's particles grows with the displacements."""
    size = volume * trial.after.ratio
    turn = turned(mesh.gradient_of(trial.u), trial.after.growth)
    n, dim = turn.shape[:2]
    sums = sparse.csr_array((np.ones(n), (cells.of, np.arange(n))), shape=(len(cells), n))
    along = [sums @ sum(sparse.diags_array(size * turn[:, a, b]) @ G for b, G in enumerate(mesh.G)) for a in range(dim)]
    order = np.arange(dim * mesh.n_nodes).reshape(dim, -1).T.ravel()
    return sparse.csc_array(sparse.hstack(along, format="csc"))[:, order]


def pull_of(around, pores, p):
    """s (n,) [Pa] of `Balance` of cells with the pressures p under a pressure `around` (n,), or None."""
    return (0.0 if around is None else around) - p[pores.cells.of]


def drained_modulus(balance, trial):
    """K_dr (n,) [Pa] of each particle: C_iikk / dim^2 of the laws' tangents, against equal compression along all axes;
    trial: with tangents, at the pull of the balance."""
    C, dim = trial.after.C, trial.after.P.shape[1]
    total = np.einsum("niikk->n", C) / dim**2
    if balance.pull is not None:  # dP of the pull: s J (dim^2 - dim) / dim^2 at f = I
        total = total - balance.pull * trial.after.ratio * (1.0 - 1.0 / dim)
    return total


def solve_at_once(balance, linear, rules, start):
    """`Solved` of an `AtOnce` and the pressures, from displacements start (free,)."""
    first = np.concatenate([start, balance.pores.start / balance._unit])
    solved = solve(balance, linear, rules.tolerance, rules.iterations, start=first)
    return solved, balance.pressure(solved.trial.v), 1


def solve_in_turn(balance, linear, rules, coupling, pores, start):
    """`Solved` of a `Balance`, the pressures and the passes by the fixed-stress split. Raises NotConverged."""
    around, p = balance.pull, pores.start
    balance.pull = pull_of(around, pores, p)
    trial = balance.at(np.zeros_like(start), tangents=True)
    modulus = pores.cells.mean(drained_modulus(balance, trial), balance.volume)
    if not (modulus > 0.0).all():
        raise NotConverged("the skeleton has no stiffness")
    added = coupling.alpha * pores.bulk / modulus
    if start.any():
        trial = balance.at(start)
    noise, first = ROUND_OFF * float(np.linalg.norm(pores.content)), 0.0
    residuals: list[Any] = []
    for passes in range(coupling.passes + 1):
        left = float(np.linalg.norm(pores.residual(p, trial.after.ratio)))
        first = max(first, left) if passes < 2 else first  # a load comes in with the skeleton's first answer
        if not left <= FLED * max(first, noise):
            break
        if passes and left <= coupling.tolerance * first + noise:
            return Solved(trial, residuals), p, passes
        p = p + pores.correction(p, trial.after.ratio, added)
        balance.pull = pull_of(around, pores, p)
        solved = solve(balance, linear, rules.tolerance, rules.iterations, start=trial.v)
        trial = solved.trial
        residuals = residuals + solved.residuals
    raise NotConverged(f"the fixed-stress split left {left / max(first, noise):.1e} of the first residual of the water"
                       f" in {passes} passes: take water.split = \"monolithic\", or a larger water.alpha or"
                       " water.iterations")
