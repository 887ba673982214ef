"""Which blocks of rows may hold neighbours of a block: its own, those around it, and what mirrors show of them.

Rows come in groups, one a surface; a group may also be seen in the mirror of a side, or of several. See `neighbours`
for what is made of it.
"""

from typing import Any

import numpy as np

from snowmpm.particles.blocks import EDGE

BEGIN, END, SURFACE, MIRRORED = range(4)
"""Integer columns of the table of candidates."""


class Group:
    """Rows of one surface (-1: particles), sorted by block: keys (n,) of blocks, start (n + 1,) rows."""

    def __init__(self, surface, blocks, first_row=0):
        self.surface, self.blocks = surface, blocks
        self.start = blocks.start.astype(np.int64) + first_row


def candidates(targets, groups, mirrors, reach):
    """Which groups of rows may hold neighbours of each block.

    targets: block coordinates (blocks, dim); groups: [Group]; mirrors: [(surface, axis, level [cells])]; reach [cells].
    -> start (blocks + 1,), ints (m, 4): BEGIN, END, SURFACE (of the mirror for particles seen in one), MIRRORED;
    reals (m, 2 dim): signs and offsets.
    """
    dim = targets.shape[1]
    edge = EDGE[dim]
    rings = int(np.ceil(reach / edge - 1e-9))
    ints, reals, owner = [], [], []
    target = np.asarray(targets, np.int64)
    every = np.arange(len(targets))

    def add(block, group, number, step, mirrored):
        """Group `group`'s blocks `number`, `step` blocks away from target blocks `block`, seen in mirrors."""
        sign, offset = np.ones((len(block), dim)), edge * step.astype(float)
        surface = np.full(len(block), group.surface)
        for mirror, axis, level in mirrored:
            sign[:, axis] = -1.0
            offset[:, axis] = 2.0 * level - edge * (target[block, axis] + target[block, axis] + step[:, axis])
            if group.surface < 0:
                surface[:] = mirror
        ints.append(np.stack([group.start[number], group.start[number + 1], surface,
                              np.full(len(block), len(mirrored))], axis=1))
        reals.append(np.concatenate([sign, offset], axis=1))
        owner.append(block)

    combinations: list[list[Any]] = [[]]
    for mirror in mirrors:
        combinations += [[*some, mirror] for some in combinations if all(one[1] != mirror[1] for one in some)]
    for some in combinations:
        near = every
        for _, axis, level in some:
            low = edge * target[near, axis] + 0.5
            near = near[(low - level < reach) & (level - low - edge < reach)]
        if len(near) == 0:
            continue
        ranges = [np.arange(-rings - 1, rings + 2) if any(one[1] == a for one in some)
                  else np.arange(-rings, rings + 1) for a in range(dim)]
        for step in np.stack(np.meshgrid(*ranges, indexing="ij"), axis=-1).reshape(-1, dim):
            around = target[near] + step
            seen = np.ones(len(near), bool)
            for _, axis, level in some:
                low = edge * around[:, axis] + 0.5
                seen &= (low - level < reach) & (level - low - edge < reach)
            for group in groups:
                number, found = group.blocks.find(around)
                found &= seen
                if found.any():
                    add(near[found], group, number[found], np.tile(step, (found.sum(), 1)), some)
    if not ints:
        return np.zeros(len(targets) + 1, np.int64), np.zeros((0, 4), np.int64), np.zeros((0, 2 * dim))
    found, target_of = np.concatenate(ints), np.concatenate(owner)
    order = np.lexsort((found[:, BEGIN], found[:, MIRRORED], found[:, SURFACE], target_of))
    start = np.concatenate([[0], np.cumsum(np.bincount(target_of, minlength=len(targets)))])
    return start, found[order], np.concatenate(reals)[order]
