"""How fast this machine is, against the one that the costs were measured on, from a tenth of a second of work.

Two kinds of work, as a run has them: vector arithmetic on numbers that lie in the cache (kernels over particles and
nodes), and Python (launches, frames). Each is the fastest of several tries, so that other programs weigh little.
"""

import functools
import time
from dataclasses import dataclass

import numpy as np

TRIES = 8
LENGTH, ROUNDS = 4096, 200
LOOPS = 10_000


@dataclass(frozen=True)
class Speed:
    """Nanoseconds of one vector operation a number, and of one round of a Python loop."""

    vector: float
    python: float

    def over(self, other):
        """How many times as long this machine takes as `other`: (vector, python)."""
        return self.vector / other.vector, self.python / other.python


@functools.cache
def measured_speed():
    """`Speed` of this machine."""
    samples = [speed_now() for _ in range(TRIES)]
    return Speed(min(one.vector for one in samples), min(one.python for one in samples))


def speed_now():
    """`Speed` in this moment, in processor time: a core that is shared with others is slower.

    Of the thread: the clock of the process stands still for milliseconds where its processor time is limited.
    """
    return Speed(_vector(), _python())


def _vector():
    values = np.linspace(0.5, 1.5, LENGTH, dtype=np.float32)
    result = np.zeros_like(values)
    start = time.thread_time()
    for _ in range(ROUNDS):
        np.multiply(result, values, out=result)
        np.add(result, np.float32(0.5), out=result)
        np.sqrt(result, out=result)
    return 1e9 * (time.thread_time() - start) / (3 * LENGTH * ROUNDS)


def _python():
    total, start = 0.0, time.thread_time()
    for i in range(LOOPS):
        total += abs(i - total) * 1e-3
    return 1e9 * (time.thread_time() - start) / LOOPS
