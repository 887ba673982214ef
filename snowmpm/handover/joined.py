"""The snow of two methods that work at the same time, as that of one."""

import numpy as np

from snowmpm.annotations import derived
from snowmpm.particles.contract import Particles
from snowmpm.particles.snapshot_probe import SnapshotProbe


class JoinedSnapshot:
    """Rows of one snapshot, then those of another, whose columns count where the first one has others."""

    def __init__(self, first, second, sizes):
        self._parts, self._sizes = (first, second), sizes
        self.labels = np.concatenate([part.labels for part in self._parts])

    def column(self, name):
        """(n, size), float64; zero where a part does not have it."""
        parts = [part.column(name) for part in self._parts]
        width = max(part.shape[1] for part in parts)
        return np.concatenate([np.pad(part, ((0, 0), (0, width - part.shape[1]))) for part in parts])

    def positions(self):
        """Scene coordinates [m] (n, dim)."""
        return np.concatenate([part.positions() for part in self._parts])

    def plan(self):
        """Places in plan (n, dim - 1) [m]."""
        return np.concatenate([part.plan() for part in self._parts])

    def depth(self):
        """Thickness of the snow at each (n,) [m], zero for particles in space."""
        return np.concatenate([part.depth() for part in self._parts])


class JoinedParticles(Particles):
    """first, second: `Particles` of the two methods; passed: what went from one to the other so far, as `removed`,
    which both count as gone; numbering: `handover.numbering.Numbering`."""

    def __init__(self, first, second, numbering):
        self._parts = first, second
        self.numbering = numbering
        self.passed = {name: 0 * value for name, value in self._sum().items()}
        self.moved = 0
        """`moves` of the last step"""

    def _sum(self):
        first, second = (part.removed for part in self._parts)
        return {name: first.get(name, 0) + second.get(name, 0) for name in {**first, **second}}

    @derived
    def removed(self):
        """`Particles.removed` of both, without what went to the other."""
        return {name: value - self.passed[name] for name, value in self._sum().items()}

    def pass_on(self, amounts):
        """Count what one method gave the other, by name as in `removed`."""
        self.passed = {name: value + amounts.get(name, 0) for name, value in self.passed.items()}

    @derived
    def constants(self):
        """Of both."""
        return {**self._parts[0].constants, **self._parts[1].constants}

    @derived
    def moves(self):
        """Columns, and particles as often as they moved in the step of the columns."""
        return self.moved

    @derived
    def count(self):
        """How many there are now."""
        return sum(part.count for part in self._parts)

    @derived
    def waiting(self):
        """None that are last."""
        return 0

    @derived
    def mass(self):
        """Of all [kg]."""
        return sum(part.mass for part in self._parts)

    @derived
    def materials(self):
        """Laws as on the finer grid."""
        return self._parts[1].materials

    @derived
    def repeats(self):
        """None: refused before."""
        return self._parts[0].repeats

    @derived
    def sorts(self):
        """How often the order of the rows changed."""
        return sum(part.sorts for part in self._parts)

    @derived
    def bodies(self):
        """Index of the body by number."""
        return self.numbering.bodies

    @derived
    def origins(self):
        """Where the snow of each number was at time zero [m]."""
        return self.numbering.origins

    @property
    def sizes(self):
        """Numbers that a particle carries."""
        return self._parts[1].sizes

    @property
    def number_bytes(self):
        """Bytes of a number."""
        return max(part.number_bytes for part in self._parts)

    @property
    def bytes_per_particle(self):
        """Memory of a particle, of those that take most."""
        return max(part.bytes_per_particle for part in self._parts)

    @property
    def n_blocks(self):
        """Blocks of cells that hold some."""
        return sum(part.n_blocks for part in self._parts)

    def snapshot(self):
        """`JoinedSnapshot` of all as they are now."""
        first, second = self._parts
        return JoinedSnapshot(first.snapshot(), second.snapshot(), self.sizes)

    def column(self, name):
        """Copy of one column, float64, (n, size)."""
        return self.snapshot().column(name)

    def positions(self):
        """Scene coordinates [m] (n, dim)."""
        return self.snapshot().positions()

    def probe(self, chosen, total):
        """`SnapshotProbe` of those with the numbers `chosen` (k,)."""
        return SnapshotProbe(self, chosen)

    def sums_in_plan(self, lower, cell, shape):
        """Sums over plan cells of both (`Particles.sums_in_plan`)."""
        parts = [part.sums_in_plan(lower, cell, shape) for part in self._parts]
        parts = [(window, sums) for window, sums in parts if sums.size]
        if not parts:
            return (slice(0, 0), slice(0, 0)), np.zeros((0, 0, 6))
        whole = tuple(slice(min(window[a].start for window, _ in parts), max(window[a].stop for window, _ in parts))
                      for a in (0, 1))
        added = np.zeros((*(part.stop - part.start for part in whole), 6))
        for window, sums in parts:
            added[tuple(slice(own.start - all_.start, own.stop - all_.start)
                        for own, all_ in zip(window, whole, strict=True))] += sums
        return whole, added

    def resting_in_plan(self, lower, cell, shape):
        """Volume over each plan cell of snow that is no part of the flow."""
        found = [part.resting_in_plan(lower, cell, shape) for part in self._parts]
        found = [one for one in found if one is not None]
        return sum(found) if found else None
