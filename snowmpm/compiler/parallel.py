"""How work is handed to threads.

Taichi gives a thread of a CPU up to 512 consecutive iterations of a parallel loop at a time, so a loop over a few
hundred blocks would run on one thread. Loops here run over `chunks(chunk_bounds)` iterations of which every 512th is a
worker; worker k takes the k-th contiguous chunk of the blocks. What a block computes does not depend on who computes
it. A GPU's threads are many and slow: there every iteration is a worker, which takes a block or a few.

    for i in range(chunks(shares)):
        if is_worker(i):
            first, last = chunk(i, shares)

What workers found is added up in order on a CPU, so that sums do not depend on the number of threads, and by atomics on
a GPU, one of whose threads would take longer for it than all of them for the step:

    ti.loop_config(serialize=in_order())

Where there are as many of these as particles, each thread of a GPU first adds up every `partial_sums(n)`-th:

    ti.loop_config(serialize=in_order())
    for i in range(partial_sums(n)):

Where few of many items have work, and these lie together (tiles of a plan grid that hold snow), a worker takes every
k-th item:

    for i in range(strides(n)):
        item = strided(i, n)
        if item < n:
"""

import numpy as np

from snowmpm.compiler import runtime
from snowmpm.compiler.backend import ti
from snowmpm.compiler.settings import SPREAD

CHUNKS_PER_THREAD = 12
"""Chunks each thread of a CPU gets on average: enough to even out blocks of unequal cost."""
LITTLE_WORK = 4e-4
"""Time of a step [s] below which its loops are not worth handing out, to two threads or sixteen."""
STRIDED = 31
"""Workers at least that share such items on a CPU: a prime, so that no row of tiles falls to one of them."""
GPU_WORKERS = 1 << 15
"""Chunks on a GPU: enough to hide the latency of its memory, few enough for a scratch block each."""
GPU_SUMS = 1 << 12
"""Partial sums on a GPU: atomics to one number follow each other."""


def most_workers():
    """Largest number of chunks that a loop is cut into."""
    return GPU_WORKERS if runtime.fine_grained() else CHUNKS_PER_THREAD * runtime.threads()


def in_order():
    """Whether sums over blocks are made one after the other."""
    return not runtime.fine_grained()


def spread():
    """Iterations from one worker to the next."""
    return 1 if runtime.fine_grained() else SPREAD


def chunk_bounds(cost):
    """Ends of chunks of about equal cost, (workers + 1,) from 0 to n, for blocks of the given costs (n,) > 0.

    Blocks are very unequal in a flow: a few hold most of the snow, thousands a few grains each.
    """
    total = np.cumsum(cost)
    n = min(len(total), most_workers())
    if n == 0:
        return np.zeros(2, np.int32)
    ends = np.searchsorted(total, total[-1] * np.arange(1, n) / n)
    return np.concatenate([[0], ends, [len(total)]]).astype(np.int32)


def runs_serially(work=None):
    """Whether one thread should do a loop itself, for `ti.loop_config(serialize=...)`.

    work: of a step, an estimate of its time on one thread [s]: where it is little, whatever the number of threads, so
    that this number does not choose between two codes, which the compiler may round differently; without it, where
    there is one thread only. To hand a loop to others takes 0.02 to 0.1 ms, and a step has five or six.
    """
    if runtime.fine_grained():
        return False
    return runtime.threads() == 1 if work is None else work < LITTLE_WORK


@ti.func
def partial_sums(n):
    """Partial sums over n items: one an item where they are added up in order."""
    return ti.select(ti.static(in_order()), n, ti.min(n, GPU_SUMS))


@ti.func
def chunks(chunk_bounds: ti.template()):
    """Length of that loop."""
    return (chunk_bounds.shape[0] - 1) * ti.static(spread())


@ti.func
def is_worker(i):
    """Whether iteration i of that loop is a worker's."""
    return i % ti.static(spread()) == 0


@ti.func
def worker(i):
    """Number of the worker at iteration i."""
    return i // ti.static(spread())


@ti.func
def chunk(i, chunk_bounds: ti.template()):
    """First and one-past-last block of the worker at iteration i."""
    k = worker(i)
    return chunk_bounds[k], chunk_bounds[k + 1]


@ti.func
def _strided_workers(n):
    found = n
    if ti.static(spread() > 1):
        found = ti.max(STRIDED, (n - 1) // ti.static(spread()) + 1)
    return found


@ti.func
def strides(n):
    """Length of a loop over n items that workers take in turn."""
    return _strided_workers(n) * ti.static(spread())


@ti.func
def strided(i, n):
    """The item of iteration i of that loop; there is none if it is n or more."""
    return i // ti.static(spread()) + i % ti.static(spread()) * _strided_workers(n)
