"""To what a published number of hazard mapping is known: its resolution, and its digits.

Places and lengths are known to half a map cell; heights to what the ground falls over that; the travel angle to what
both make of it; areas to half a cell all along their rim, taken as that of a square, since flow that is painted on
cells is wider than it is; times to half the interval of the frames. Peaks of depth, speed and pressure have no such
resolution: what they are good for only a second grid tells.
"""

import math
from collections.abc import Mapping

DIGITS = 4
"""Digits of numbers without a resolution."""

LENGTHS = ("runout", "runout_x", "runout_y", "deposit_reach", "deposit_reach_x", "deposit_reach_y")
HEIGHTS = ("runout_z", "deposit_reach_z", "fall", "top")


def resolutions(numbers: Mapping[str, float], cell: float) -> dict[str, float]:
    """{name: resolution} of numbers of hazard mapping; cell: side of the map cells [m]. Those without are left out."""
    found = {name: 0.5 * cell for name in numbers if name in LENGTHS or name.startswith("reach_of_")}
    run, fall = numbers.get("runout"), numbers.get("fall")
    if run and fall is not None:
        steepness = abs(fall) / run
        found |= {name: 0.5 * cell * steepness for name in HEIGHTS if name in numbers}
        both = 0.5 * cell * math.hypot(steepness, steepness) / run
        found["travel_angle"] = math.degrees(both / (1.0 + steepness**2))
    for name, value in numbers.items():
        if name != "release_area" and "area" in name.split("_") and value > 0.0:
            found[name] = max(cell**2, 2.0 * cell * math.sqrt(value))
    return {name: value for name, value in found.items() if value > 0.0}


def rounded(value: float, resolution: float | None = None) -> float:
    """A number to the decimal place of its resolution; without one to `DIGITS` digits."""
    if isinstance(value, bool) or not math.isfinite(value):
        return value
    if not resolution:
        return float(f"{value:.{DIGITS}g}")
    return round(value, -math.floor(math.log10(resolution))) + 0.0


def published(numbers: Mapping[str, float], cell: float) -> dict[str, float]:
    """Numbers of hazard mapping, rounded each to its resolution."""
    known = resolutions(numbers, cell)
    return {name: rounded(value, known.get(name)) for name, value in numbers.items()}
