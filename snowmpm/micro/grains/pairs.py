"""Which grains may touch: pairs within a margin, and what their contacts remember."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree


@dataclass(frozen=True)
class Pairs:
    """first, second (m,): grains of each pair, in rising order; starts (n + 1,), members (2 m,): the pairs of each
    grain, a pair where it is first as k, where it is second as -k - 1."""

    first: np.ndarray
    second: np.ndarray
    starts: np.ndarray
    members: np.ndarray

    @property
    def count(self):
        return len(self.first)

    @classmethod
    def near(cls, positions, radii, margin, box=None):
        """All pairs with a gap below `margin` [m]; box (3,): of a periodic cell, or None."""
        n = len(positions)
        at = positions if box is None else np.mod(positions, box)
        if box is not None:
            at = np.where(at >= box, 0.0, at)  # round-off of the remainder
        found = cKDTree(at, boxsize=box).query_pairs(2.0 * radii.max(initial=0.0) + margin, output_type="ndarray")
        found = np.sort(found, axis=1).reshape(-1, 2)
        way = at[found[:, 0]] - at[found[:, 1]]
        if box is not None:
            way -= box * np.round(way / box)
        gap = np.linalg.norm(way, axis=1) - radii[found[:, 0]] - radii[found[:, 1]]
        found = found[gap < margin]
        found = found[np.lexsort((found[:, 1], found[:, 0]))]
        first, second = found.T.astype(np.int32)
        grain = np.concatenate([first, second])
        entry = np.concatenate([np.arange(len(first)), -np.arange(len(first)) - 1])
        order = np.argsort(grain, kind="stable")
        starts = np.concatenate([[0], np.cumsum(np.bincount(grain, minlength=n))]).astype(np.int32)
        return cls(first, second, starts, entry[order].astype(np.int32))

    def carried(self, before, memory):
        """What contacts remember (m, k) of pairs `before` (j, k), by these pairs; zero of new ones."""
        kept = np.zeros((self.count, memory.shape[1]), memory.dtype)
        if before is None or not before.count or not self.count:
            return kept
        n = 1 + int(max(self.second.max(), before.second.max()))
        old, new = (one.first.astype(np.int64) * n + one.second for one in (before, self))
        at = np.searchsorted(old, new).clip(0, len(old) - 1)
        same = old[at] == new
        kept[same] = memory[at[same]]
        return kept
