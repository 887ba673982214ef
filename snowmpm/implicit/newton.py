"""Newton's method with a line search, and what it says when it fails."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from snowmpm.implicit.linear import Singular

ENOUGH = 0.8
"""Share of its first value to which the work of the residual on a step must fall."""

SHORTENINGS = 8

MOST_WASTED = 6
"""Iterations in turn that do not come below the smallest residual so far."""

LEFT = 1e-4
"""What a linear solve by iterations leaves of its right-hand side, unless less is enough: what Newton gains a turn."""


class NotConverged(Exception):
    """The equations of a step were not solved. residual: |R| over the size of the forces; node: where it is largest."""

    def __init__(self, reason, residual=np.inf, node=None, trace=()):
        super().__init__(reason)
        self.residual, self.node, self.trace = residual, node, trace


@dataclass
class Solved:
    """A step that was solved: `balance.Trial`, |R| over the forces of each iterate, and of water in the pores `Pores`
    and pressures."""

    trial: Any
    residuals: list = field(default_factory=list)
    flow: tuple = ()


def solve(balance, linear, tolerance, most, left=0.0, start=None):
    """`Solved` of a `Balance`, from displacements `start` (free,), or 0.

    tolerance: |T^T R| over the size of the forces; most: iterations; left: share of the first residual that stays, for
    a load that is applied in parts. Raises NotConverged.

    Full steps come first: a slender body that turns passes through residuals far larger than the first one, which a
    line search would shun, in ten times as many steps. Where they lead nowhere, steps that a line search shortens do.
    """
    first = balance.at(np.zeros(balance.held.T.shape[1]) if start is None else start)
    if not first.sound and start is not None:
        first = balance.at(0.0 * start)
    if not first.sound:
        raise NotConverged("a stress or a velocity is not finite")
    try:
        return _iterate(balance, linear, (tolerance, most), first, left, search=False)
    except NotConverged:
        return _iterate(balance, linear, (tolerance, most), first, left, search=True)


def _iterate(balance, linear, limits, trial, left, search):
    """Newton's method from a trial. limits: tolerance and most iterations."""
    (tolerance, most), rest = limits, left * trial.free
    residuals, scale, best, wasted = [], trial.scale, np.inf, 0
    while True:
        scale = max(scale, trial.scale)
        r = trial.free - rest
        size = float(np.linalg.norm(r))
        residuals.append(size / scale if scale > 0.0 else 0.0)
        if size <= tolerance * scale + trial.noise:
            return Solved(trial, residuals)
        if len(residuals) > 1:  # the first one may be small, and nothing that follows
            best, wasted = (size, 0) if size < best else (best, wasted + 1)
        if len(residuals) > most or wasted > MOST_WASTED or not np.isfinite(size):
            break
        exact = balance.with_tangents(trial)
        try:
            step = linear.solve(balance.matrix(exact), -r, min(max(LEFT, 0.3 * tolerance * scale / size), 0.1))
        except Singular as error:
            raise NotConverged(str(error), residuals[-1], _worst(balance, r)) from error
        trial = _searched(balance, trial, step, r, rest) if search else _full(balance, trial, step, r)
    raise NotConverged(f"|R| stayed at {min(residuals):.1e} of the forces in {len(residuals) - 1} iterations",
                       residuals[-1], _worst(balance, trial.free - rest), residuals)


def _full(balance, trial, step, r):
    """The trial at the end of a step, or of the longest half of it that turns nothing inside out."""
    share = 1.0
    for _ in range(SHORTENINGS):
        found = balance.at(trial.v + share * step)
        if found.sound:
            return found
        share *= 0.5
    raise NotConverged("particles are turned inside out", np.inf, _worst(balance, r))


def _searched(balance, trial, step, r, rest):
    """The trial at the end of a step, or of a shorter one whose residual does less work."""
    share, before, size = 1.0, float(step @ r), float(np.linalg.norm(r))
    best = None
    for _ in range(SHORTENINGS):
        found = balance.at(trial.v + share * step)
        if not found.sound:
            share *= 0.5
            continue
        after, left = float(step @ (found.free - rest)), float(np.linalg.norm(found.free - rest))
        if best is None or left < best[0]:
            best = left, found
        if left < size or abs(after) <= ENOUGH * abs(before):
            return found
        slope = (after - before) / share
        ideal = -before / slope if slope != 0.0 else 0.5 * share
        share = min(max(ideal, 0.1 * share), 0.5 * share)
    if best is None:
        raise NotConverged("particles are turned inside out", np.inf, _worst(balance, r))
    return best[1]


def _worst(balance, r):
    """Place of the node with the largest residual [cells]."""
    full = np.abs(balance.held.full(r) - balance.held.full(0.0 * r))
    return balance.mesh.nodes[int(np.argmax(full.sum(axis=1)))]
