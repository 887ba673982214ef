"""Which grains may touch: pairs within a margin, and what their contacts remember."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree


def nearest_image(way, box, slide=(0.0, 0.0)):
    """Vectors (m, 3) between grains to the nearest image; box (3,): sides of the cell, 0 along axes without; slide (2,)
    [m]: shift of the image above along z, in x and y."""
    sides = np.maximum(box, 1e-300)
    over = np.where(box[2] > 0.0, np.round(way[:, 2] / sides[2]), 0.0)
    way = way - over[:, None] * np.array([*slide, box[2]])
    way[:, :2] -= np.where(box[:2] > 0.0, box[:2] * np.round(way[:, :2] / sides[:2]), 0.0)
    return way


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
    def near(cls, positions, radii, margin, box=None, slide=(0.0, 0.0)):
        """All pairs with a gap below `margin` [m]; box (3,): of a periodic cell, or None; slide: `nearest_image`.

        The tree knows upright cells only: it takes the positions before the slide, which brings no two nearer than by
        the factor 1 / (1 + |slide| / height).
        """
        n = len(positions)
        at, reach = positions, 2.0 * radii.max(initial=0.0) + margin
        if box is not None:
            at = positions - positions[:, 2:] * np.array([*slide, 0.0]) / box[2]
            at = np.mod(at, box)
            at = np.where(at >= box, 0.0, at)  # round-off of the remainder
            reach *= 1.0 + float(np.hypot(*slide)) / box[2]
        found = cKDTree(at, boxsize=box).query_pairs(reach, output_type="ndarray")
        found = np.sort(found, axis=1).reshape(-1, 2)
        way = positions[found[:, 0]] - positions[found[:, 1]]
        if box is not None:
            way = nearest_image(way, box, slide)
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
