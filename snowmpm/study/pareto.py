"""What a table of measurements says: fronts, orders, floors, time to the same error, noise."""

import itertools
from dataclasses import dataclass

import numpy as np

from snowmpm.study.measurement import least_of

FLOOR_SHARE = 0.5
"""A grid whose error falls at less than this share of the order of the finest drop before it lies on a floor."""


def merged(rows):
    """One row of each key, with the least time of its repeats, in the order of the table."""
    groups = {}
    for row in rows:
        groups.setdefault(row.key, []).append(row)
    return [least_of(group) for group in groups.values()]


def noise(rows):
    """-> (largest spread of the times of repeats, of their errors), each over the least; (0, 0) without repeats."""
    groups = {}
    for row in rows:
        groups.setdefault(row.key, []).append(row)
    spread = [[np.ptp(values) / min(values) if min(values) else 0.0 for values in
               ([row.seconds for row in group], [row.error for row in group])]
              for group in groups.values() if len(group) > 1]
    return tuple(float(value) for value in np.max(spread, axis=0)) if spread else (0.0, 0.0)


def front(rows, cost="seconds"):
    """Rows that no other beats in both error and cost ("work", "seconds" or "particle_steps"), cheap to dear."""
    chosen, best = [], np.inf
    for row in sorted(rows, key=lambda row: (row[cost], row.error)):
        if row.error < best:
            chosen.append(row)
            best = row.error
    return chosen


def orders(rows):
    """Order of convergence between neighbours of a refinement: [(coarse cells, fine cells, order)]."""
    rows = sorted(rows, key=lambda row: row.cells)
    return [(a.cells, b.cells, float(np.log(a.error / b.error) / np.log(b.cells / a.cells)))
            for a, b in itertools.pairwise(rows)]


@dataclass(frozen=True)
class Refinement:
    """One variation of one problem, coarse to fine.

    order: of the error with dx before the floor; range: cells between which; floor: coarsest cells from which on the
    error falls at less than FLOOR_SHARE of the steepest drop, or None.
    """

    order: float
    range: tuple
    floor: int | None

    @classmethod
    def of(cls, rows):
        """Of at least two rows."""
        found = orders(rows)
        steepest = max(order for *_, order in found)
        if steepest <= 0.0:
            return cls(steepest, (found[0][0], found[-1][1]), found[0][0])
        last = max(k for k, (*_, order) in enumerate(found) if order >= FLOOR_SHARE * steepest)
        falling = [row for row in rows if found[0][0] <= row.cells <= found[last][1]]
        slope = -np.polyfit(np.log([row.cells for row in falling]), np.log([row.error for row in falling]), 1)[0]
        floor = found[last][1] if last + 1 < len(found) else None
        return cls(float(slope), (found[0][0], found[last][1]), floor)


def time_to(rows, error, cost="seconds"):
    """Cost at which a refinement reaches `error`, by straight lines in logarithms; nan where it does not."""
    rows = front(rows, cost)
    if not rows or not rows[-1].error <= error <= rows[0].error:
        return float("nan")
    errors, costs = (np.log([row[name] for row in reversed(rows)]) for name in ("error", cost))
    return float(np.exp(np.interp(np.log(error), errors, costs)))
