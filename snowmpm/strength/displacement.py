"""How a slope moved in a run: ways of its particles, its speed at the end, and what slid on what."""

from dataclasses import dataclass

import numpy as np

from snowmpm.annotations import Floats
from snowmpm.io import Run

EXCEEDED = 0.99
"""Quantile of ways and speeds: a grain that rolls down a face is no slide."""
LAST = 0.9
"""Share of the time after which it should be at rest."""
SLID = 0.5
"""Way over the quantile of all, from which on a particle belongs to the slide."""


@dataclass(frozen=True)
class Ways:
    """Of the particles that are there at all times (frames,) [s]: positions at the start (n, dim) [m] and ways
    (frames, n) [m]."""

    times: Floats
    start: Floats
    ways: Floats
    last: Floats
    """ways in the last tenth of the time (n,) [m]"""

    @property
    def largest(self) -> Floats:
        """Way that 1 % exceed at each time (frames,) [m]."""
        return np.asarray(np.quantile(self.ways, EXCEEDED, axis=1))

    @property
    def speed(self) -> float:
        """Speed that 1 % exceed, a mean over the last tenth of the time [m/s]."""
        late = self.times[-1] - self.times[_late(self.times)]
        return float(np.quantile(self.last, EXCEEDED) / late)

    @property
    def slid(self) -> Floats:
        """Which particles belong to the slide (n,)."""
        return np.asarray(self.ways[-1] > SLID * self.largest[-1])


def ways_of(run: Run) -> Ways:
    """`Ways` of a run whose frames hold "id"."""
    frames = [run.frame(i) for i in range(len(run))]
    kept = frames[0].fields["id"]
    for frame in frames[1:]:
        kept = np.intersect1d(kept, frame.fields["id"])
    axes = [0, 2] if run.dimension == 2 else [0, 1, 2]
    at = np.array([frame.positions[np.argsort(frame.fields["id"])][
        np.isin(np.sort(frame.fields["id"]), kept)][:, axes] for frame in frames])
    times = np.asarray(run.times)
    return Ways(times, at[0], np.linalg.norm(at - at[0], axis=2), np.linalg.norm(at[-1] - at[_late(times)], axis=1))


def _late(times: Floats) -> int:
    """The frame nearest to `LAST` of the time."""
    return int(np.argmin(np.abs(times - LAST * times[-1])))


def slip_surface(ways: Ways, cell: float) -> Floats:
    """The lower border of the slide (m, dim) [m]: in each plan cell the lowest particle of it, by x in 2-D."""
    inside = ways.start[ways.slid]
    plan = np.floor(inside[:, :-1] / cell).astype(np.int64)
    cells, label = np.unique(plan, axis=0, return_inverse=True)
    lowest = np.full(len(cells), np.inf)
    np.minimum.at(lowest, label.reshape(-1), inside[:, -1])
    return np.column_stack([(cells + 0.5) * cell, lowest])
