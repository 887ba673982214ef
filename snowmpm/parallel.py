"""How coarse work is handed to CPU threads.

Taichi gives a thread up to 512 consecutive iterations of a parallel loop at a time, so a loop over a few hundred blocks
would run on one thread. Loops here run over `chunks(shares)` iterations of which every 512th is a worker; worker k
takes the k-th contiguous chunk of the blocks. What a block computes does not depend on who computes it.

    for i in range(chunks(shares)):
        if is_worker(i):
            first, last = chunk(i, shares)
"""

import numpy as np
import taichi as ti

from snowmpm import runtime

SPREAD = 512
"""Iterations of a parallel loop that Taichi gives to a thread at a time."""
CHUNKS_PER_THREAD = 12
"""Chunks each thread gets on average: enough to even out blocks of unequal cost."""


def most_workers():
    """Largest number of chunks that a loop is cut into."""
    return CHUNKS_PER_THREAD * runtime.threads()


def shares(cost):
    """Ends of chunks of about equal cost, (workers + 1,) from 0 to n, for blocks of the given costs (n,) > 0.

    Blocks are very unequal in a flow: a few hold most of the snow, thousands a few grains each.
    """
    total = np.cumsum(cost)
    n = min(len(total), most_workers())
    if n == 0:
        return np.zeros(2, np.int32)
    ends = np.searchsorted(total, total[-1] * np.arange(1, n) / n)
    return np.concatenate([[0], ends, [len(total)]]).astype(np.int32)


def alone():
    """Whether there is one thread, for `ti.loop_config(serialize=...)`: handing a loop to it would take 0.1 ms, what
    300 particles of a sum over neighbours do."""
    return runtime.backend() == "cpu" and runtime.threads() == 1


@ti.func
def chunks(shares: ti.template()):
    """Length of the loop whose every SPREAD-th turn is a worker's."""
    return (shares.shape[0] - 1) * SPREAD


@ti.func
def is_worker(i):
    """Whether turn i of that loop is a worker's."""
    return i % SPREAD == 0


@ti.func
def chunk(i, shares: ti.template()):
    """First and one-past-last block of the worker at iteration i."""
    k = i // SPREAD
    return shares[k], shares[k + 1]
