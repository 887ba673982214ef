"""Rest of a framework: where its forces balance those from without.

With f what elements and g what loads give the places and turns that are free, and u displacements and spins of these,

    f(u) + (1 - s) g_0 + s g = 0,    s from 0 to 1,    -f(0) = g_0

by Newton's method in the load's share s, whose steps are halved where it does not converge or an end would be stressed
beyond its strength. The tangent -df/du is taken by differences, column by column, of the forces that the motion goes
by: it has all of the rotations, of what yields and of the axial force's part. Plastic rotations are those of a load
that grows in proportion, and an end breaks where it grows to the strength. A direction that nothing resists, as the
turn of a pinned bar about itself, stays as it is.
"""

import numpy as np

from snowmpm.components.structures import framework_motion as at
from snowmpm.components.structures.framework import BEYOND
from snowmpm.errors import SimulationError

TOLERANCE, ITERATIONS = 1e-8, 15
"""|f + g| over the size of the forces, and Newton's steps, at most."""

PROBE = 1e-7
"""Of the differences: turn [rad], or way over the shortest element."""

NOTHING = 1e-11
"""Of the largest entry on the tangent's diagonal: what is added to all, so that it has an inverse."""

LARGEST_TURN = 0.5
"""Turn [rad], or way over the shortest element, in a step of Newton's method."""

LEAST_SHARE = 2.0**-16
"""Of the load: shorter steps find no balance either."""


class _NoBalance(Exception):
    pass


def bring_to_rest(one, forces):
    """Move a `Framework` to rest under forces (p, 3) [N] on its places. Raises SimulationError where there is none:
    what yields or breaks then moves on."""
    one.v[:], one._turns[:, at.SPIN : at.MOMENT] = 0.0, 0.0
    rest = _Rest(one)
    start, done, step = -rest.within(), 0.0, 1.0
    try:
        while done < 1.0:
            kept, step = one.state(), min(step, 1.0 - done)
            try:
                worst = rest.find(start + (done + step) * (forces - start))
            except _NoBalance:
                if step <= LEAST_SHARE:
                    raise
                worst = np.inf
            if worst > 1.0 + BEYOND and step > LEAST_SHARE:
                one.restore(kept)
                step *= 0.5
                continue
            done, step = done + step, 2.0 * step
            while worst >= 1.0:
                one._break()
                worst = _Rest(one).find(start + done * (forces - start))
            rest = _Rest(one)
    except _NoBalance:
        broken, yielded = np.count_nonzero(one.broken), np.count_nonzero(one.plastic.any(axis=2))
        raise SimulationError(f"finds no rest beyond {done:.3g} of its load: with {broken} ends broken and {yielded}"
                              " yielding it is a mechanism") from None


def unknowns(one):
    """How many a `Framework` has."""
    rest = _Rest(one)
    return len(rest.ways[0]) + len(rest.spins[0])


class _Rest:
    """Balance of a `Framework` as it is linked now, from the plastic rotations that it has now.

    ways, spins: (numbers, axes) of its places and turns that are free."""

    def __init__(self, one):
        self._one = one
        self._begun = one.plastic.copy(), one._elements[:, at.LARGEST].copy(), one.plastic_work
        axes, about = ([0, 2], [1]) if one.plane else (range(3), range(3))
        turns = np.flatnonzero(one._turns[:, at.FREE] > 0.0)
        self.ways, self.spins = (tuple(np.array([(i, a) for i in rows for a in axes], int).reshape(-1, 2).T)
                                   for rows, axes in ((one.free, axes), (turns, about)))
        self._unit = float(one.lengths.min())

    def within(self):
        """Forces (p, 3) [N] of the elements on the places, where they are now."""
        one = self._one
        one.plastic[:], one._elements[:, at.LARGEST], one._numbers[at.WORK] = self._begun
        one._move(0.0, 0)
        return one._places[:, at.INNER : at.MASS]

    def find(self, forces):
        """Move to rest under forces (p, 3) [N]; -> largest stress of an end over its strength. Raises _NoBalance."""
        one = self._one
        one._places[:, at.F : at.INNER] = forces
        for _ in range(ITERATIONS):
            r = self._left()
            size = max(np.abs(forces).max(), np.abs(one._places[:, at.INNER : at.MASS]).max())
            if np.abs(r).max(initial=0.0) <= TOLERANCE * size:
                return one._numbers[at.WORST]
            step = np.linalg.solve(self._tangent(r), r)
            largest = np.abs(step).max()
            if not np.isfinite(largest):
                break
            self._shift(step * min(1.0, LARGEST_TURN / largest))
        raise _NoBalance

    def _left(self):
        """Forces and moments over the unit of length, that are left, (m,) [N]."""
        self.within()
        places, turns = self._one._places, self._one._turns
        acts, moments = places[:, at.F : at.INNER] + places[:, at.INNER : at.MASS], turns[:, at.MOMENT : at.INVERSE]
        return np.concatenate([acts[self.ways], moments[self.spins] / self._unit])

    def _tangent(self, r):
        """-d`_left`/du (m, m), u over the unit of length and in rad."""
        one, found = self._one, np.empty((len(r), len(r)))
        kept = one._places.copy(), one._turns.copy()
        for k in range(len(r)):
            du = np.zeros(len(r))
            du[k] = PROBE
            self._shift(du)
            found[:, k] = (r - self._left()) / PROBE
            one._places[:], one._turns[:] = kept
        self._left()
        return found + NOTHING * np.abs(np.diag(found)).max() * np.eye(len(r))

    def _shift(self, du):
        """Displacements over the unit of length and spins, du (m,)."""
        one, n = self._one, len(self.ways[0])
        one.x[self.ways] += self._unit * du[:n]
        spins = np.zeros((len(one._turns), 3))
        spins[self.spins] = du[n:]
        for i in np.flatnonzero(spins.any(axis=1)):
            one._turns[i, at.Q : at.SPIN] = _turned(one._turns[i, at.Q : at.SPIN], spins[i])


def _turned(q, spin):
    """Quaternion q after a rotation vector in space."""
    half = 0.5 * np.linalg.norm(spin)
    c, v = np.cos(half), 0.5 * np.sinc(half / np.pi) * spin
    found = np.concatenate([[c * q[0] - v @ q[1:]], c * q[1:] + q[0] * v + np.cross(v, q[1:])])
    return found / np.linalg.norm(found)
