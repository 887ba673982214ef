"""Memory: how much is free, asked before it is taken."""

import os
import time
from pathlib import Path

from snowmpm.errors import InputError

PER_PARTICLE = {2: 650, 3: 1150}
"""Bytes that a particle needs at most, from seeding to its first frame, by dimension (measured)."""

PROGRAM = {2: 212 << 20, 3: 228 << 20}
"""Bytes of the program with its libraries and compiled kernels, by dimension of the scene (measured, +-15 % for the
laws and whether kernels are compiled or come from the disk)."""

COPIES = 22
"""Bytes of copies a number of a particle, while a frame, its diagnostics and a checkpoint are made (measured)."""


ASKED_AGAIN = 0.05
_asked = {"at": -ASKED_AGAIN, "free": 0.0}


def of_run(dimension, particles, bytes_per_particle, width, grid):
    """Most memory [bytes] that a run on a CPU takes.

    particles: their number; bytes_per_particle: in the solver's store; width: numbers each carries; grid: bytes of the
    rest of the solver.
    """
    symmetric = 4 if dimension == 2 else 6
    seeds = 8 * (2 * dimension + 1 + 2 * symmetric) + 12  # `Population`
    return int(PROGRAM[dimension] + grid + particles * (bytes_per_particle + seeds + COPIES * width))


def require(size, what, remedy="a coarser solver.dx needs less"):
    """Refuse, by an InputError that names `what` and a remedy, what needs more bytes than are free."""
    free = available()
    if not size <= free:
        raise InputError(f"{what}: needs about {gibibytes(size)} of memory, and {gibibytes(free)} are free; {remedy}")


def gibibytes(size):
    """A size in bytes as text, to three digits."""
    return f"{size / 2**30:.3g} GiB"


def available():
    """Bytes that this process may still take: of the machine, and of the group that it is confined to.

    Asked of the system at most every `ASKED_AGAIN` seconds: scenes of many bodies ask for each of them.
    """
    now = time.monotonic()
    if now - _asked["at"] > ASKED_AGAIN:
        _asked.update(at=now, free=min(_free_memory(), _left_to_group()))
    return _asked["free"]


def _free_memory():
    try:
        lines = Path("/proc/meminfo").read_text().splitlines()
        return next(int(line.split()[1]) * 1024 for line in lines if line.startswith("MemAvailable:"))
    except (OSError, StopIteration):  # not Linux: what there is at all
        return os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE") if hasattr(os, "sysconf") else float("inf")


def _left_to_group():
    """Of a container's or batch job's limit (cgroup, version 2 or 1); infinite without one.

    Files that the system keeps in memory count as used there, but make room when it is wanted.
    """
    left = float("inf")
    for folder, limit, used, cache in (("", "memory.max", "memory.current", "inactive_file"),
                                       ("memory", "memory.limit_in_bytes", "memory.usage_in_bytes",
                                        "total_inactive_file")):
        try:
            texts = [(Path("/sys/fs/cgroup", folder) / name).read_text() for name in (limit, used, "memory.stat")]
            kept = next((int(line.split()[1]) for line in texts[2].splitlines() if line.startswith(f"{cache} ")), 0)
            left = min(left, int(texts[0]) - int(texts[1]) + kept)
        except (OSError, ValueError):  # no such group, or "max": no limit
            continue
    return left
