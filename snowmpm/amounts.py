"""Large amounts in words: times and sizes, to two digits."""

import math


def long_time(seconds):
    """"27 000 years": two digits of the largest unit that fits."""
    for unit, size in (("years", 365.25 * 86400.0), ("days", 86400.0), ("hours", 3600.0), ("minutes", 60.0)):
        if seconds >= 2.0 * size:
            return f"{_two_digits(seconds / size)} {unit}"
    return f"{_two_digits(seconds)} s"


def large(size):
    """Bytes -> "40 PB", in thousands."""
    for factor, unit in ((1e18, "EB"), (1e15, "PB"), (1e12, "TB"), (1e9, "GB"), (1e6, "MB")):
        if size >= factor:
            return f"{_two_digits(size / factor)} {unit}"
    return f"{size:.0f} B"


def _two_digits(number):
    if not 0.0 < number < 1e15:
        return f"{number:.2g}"
    unit = 10.0 ** (math.floor(math.log10(number)) - 1)
    return f"{round(number / unit) * unit:,.0f}".replace(",", " ") if number >= 10.0 else f"{number:.2g}"
