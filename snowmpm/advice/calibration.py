"""Speed of this machine relative to the one on which the costs were measured, from a tenth of a second of work.

A run has two kinds of work: vector arithmetic on numbers in the cache (kernels over particles and nodes), and Python
(launches, frames). Each is timed as the fastest of several tries, to reduce the influence of other programs.
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
    """Nanoseconds of one vector operation per number, and of one iteration of a Python loop."""

    vector: float
    python: float

    def over(self, other):
        """Time of this machine over that of `other`: (vector, python)."""
        return self.vector / other.vector, self.python / other.python


@functools.cache
def measured_speed():
    """`Speed` of this machine."""
    samples = [speed_now() for _ in range(TRIES)]
    return Speed(min(one.vector for one in samples), min(one.python for one in samples))


def speed_now():
    """Current `Speed`, in processor time: a core shared with other programs is slower.

    Uses the thread's clock, since that of the process stands still for milliseconds if its processor time is limited.
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
