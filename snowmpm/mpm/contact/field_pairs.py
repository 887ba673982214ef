"""Pairs of contact blocks that hold the same nodes for two velocity fields."""

from typing import Any

import numpy as np

from snowmpm.compiler.arrays import int_array, real_array
from snowmpm.compiler.parallel import chunk_bounds


class FieldPairs:
    """Which blocks of nodes meet, and what passed between the fields there.

    totals (n, n, 1 + dim), since the start: of two of n fields, the first before the second, the energy that was taken
    [J] and the impulse that the first gave the second [N s].
    """

    everywhere: tuple[int, ...] = ()
    """Fields all of whose node blocks are contact blocks, met by others or not."""

    held = False
    """Whether the second field goes with the first, at surfaces too."""

    relief: Any = None
    """Taichi (contact nodes, dim or more): impulse [N s] that the second field took off the nodes of the first one,
    where surfaces meet the fields in turn and friction is of what is left; None where they do not"""

    def __init__(self, dim, fields):
        self.totals, self._dim = np.zeros((fields, fields, 1 + dim)), dim

    def rebuild(self, keys, fields, index):
        """Follow a block map: keys (m,) without the field, fields (m,), index (m,) of the contact block of each."""
        order = np.lexsort((fields, keys))
        pairs = [np.zeros((0, 2), np.int64)]
        for apart in range(1, int(fields.max(initial=0)) + 1):
            first, second = order[:-apart], order[apart:]
            same = keys[first] == keys[second]
            pairs.append(np.stack([first[same], second[same]], axis=1))
        pair = np.concatenate(pairs)
        rows = np.concatenate([index[pair], fields[pair]], axis=1)
        # Pairs of the same two fields share no node: they go in parallel, one kind of pair after the other
        kind = fields[pair[:, 0]] * 8 + fields[pair[:, 1]]
        self._groups = []
        for k in np.unique(kind):
            group = rows[kind == k]
            cut = int_array(chunk_bounds(np.ones(len(group))))
            part = real_array(np.zeros((len(group), 1 + self._dim)))
            self._groups.append((self.totals[k // 8, k % 8], int_array(group), part, cut, len(group)))

    @property
    def lost(self):
        """Energy that friction took since the start [J]."""
        return float(self.totals[..., 0].sum())

    @property
    def given(self):
        """Impulse that each field got from each other one since the start (n, n, dim) [N s]."""
        return self.totals[..., 1:].swapaxes(0, 1) - self.totals[..., 1:]
