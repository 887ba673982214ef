"""Numbers for reading: durations, memory, short forms."""

import math

from snowmpm.amounts import long_time
from snowmpm.glance import counted as count

__all__ = ["count", "duration", "memory", "short", "step"]


def duration(seconds):
    """42.0 s, 3 min 12 s, 1 h 02 min; "-" when unknown."""
    if seconds is None or not math.isfinite(seconds):
        return "-"
    if seconds < 60:
        return f"{seconds:.1f} s" if seconds < 10 else f"{seconds:.0f} s"
    minutes, rest = divmod(round(seconds), 60)
    if minutes < 60:
        return f"{minutes} min {rest:02d} s"
    if minutes < 100 * 60:
        return f"{minutes // 60} h {minutes % 60:02d} min"
    return long_time(seconds)


def step(seconds):
    """1.25e-4 -> 125 µs; three significant digits."""
    for factor, unit in ((1.0, "s"), (1e-3, "ms"), (1e-6, "µs")):
        if seconds >= 0.9995 * factor:
            return f"{seconds / factor:.3g} {unit}"
    return f"{seconds / 1e-9:.3g} ns"


def short(number):
    """1234567 -> 1.23 M; three significant digits."""
    if number is None or not math.isfinite(number):
        return "-"
    for factor, prefix in ((1e9, " G"), (1e6, " M"), (1e3, " k")):
        if abs(number) >= factor:
            return f"{number / factor:.3g}{prefix}"
    return f"{number:.3g}"


def memory(size):
    """Bytes -> 1.2 GiB."""
    for factor, unit in ((2**30, "GiB"), (2**20, "MiB"), (2**10, "KiB")):
        if size >= factor:
            return f"{size / factor:.1f} {unit}"
    return f"{size:.0f} B"
