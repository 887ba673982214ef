"""Snow over places in plan, which may be brought together: sums over groups of particles or columns."""

from dataclasses import dataclass

import numpy as np


@dataclass
class Heaps:
    """plan (n, 2) [m]; volume (n,) [m3] at the density of the start; velocity (n, k) [m/s]; more (n, m): whatever else
    is to be carried along as a mean over the mass; body (n,): ascending, one material each."""

    plan: np.ndarray
    volume: np.ndarray
    velocity: np.ndarray
    more: np.ndarray
    body: np.ndarray

    def __len__(self):
        return len(self.volume)

    def chosen(self, rows):
        """Some of them."""
        return Heaps(*(vars(self)[name][rows] for name in ("plan", "volume", "velocity", "more", "body")))

    @classmethod
    def joined(cls, parts):
        """All heaps of several, by body; of one body in the order of the parts."""
        body = np.concatenate([part.body for part in parts])
        order = np.argsort(body, kind="stable")
        return cls(*(np.concatenate([vars(part)[name] for part in parts])[order]
                     for name in ("plan", "volume", "velocity", "more", "body")))

    def merged(self, side):
        """One heap for all of a body that lie in the same square of side `side` [m]: mass, centre of mass and momentum
        stay (a body has one density, so that volumes weigh as masses)."""
        if not len(self):
            return self
        square = np.floor(self.plan / side).astype(np.int64)
        first, group = np.unique(np.column_stack([self.body, square]), axis=0, return_inverse=True)
        group, n = group.reshape(-1), len(first)
        volume = np.bincount(group, self.volume, n)

        def mean(values):
            sums = [np.bincount(group, self.volume * column, n) for column in values.T]
            return np.stack(sums, axis=1) / volume[:, None] if sums else np.zeros((n, 0))

        corner = side * first[:, 1:]
        # From the square's corner, so that map coordinates take no digits
        plan = corner + mean(self.plan - side * square)
        return Heaps(plan, volume, mean(self.velocity), mean(self.more), first[:, 0])
