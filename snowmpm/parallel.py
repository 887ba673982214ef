"""How coarse work is handed to CPU threads.

Taichi gives a thread up to 512 consecutive iterations of a parallel loop at a time, so a loop over a few hundred blocks
would run on one thread. Loops here run over `chunks(workers)` iterations of which every 512th is a worker; worker k
takes the k-th contiguous chunk of the blocks. What a block computes does not depend on who computes it.

    for i in range(chunks(workers)):
        if is_worker(i):
            first, last = chunk(i, workers, n)
"""

import taichi as ti

from snowmpm import runtime

SPREAD = 512
"""Iterations of a parallel loop that Taichi gives to a thread at a time."""
CHUNKS_PER_THREAD = 12
"""Chunks each thread gets on average: enough to even out blocks of unequal cost."""


def workers(n_blocks):
    """Number of chunks for a loop over n_blocks."""
    return max(1, min(n_blocks, CHUNKS_PER_THREAD * runtime.threads()))


@ti.func
def chunks(workers):
    return workers * SPREAD


@ti.func
def is_worker(i):
    return i % SPREAD == 0


@ti.func
def chunk(i, workers, n):
    """First and one-past-last block of the worker at iteration i."""
    k = i // SPREAD
    return n * k // workers, n * (k + 1) // workers
