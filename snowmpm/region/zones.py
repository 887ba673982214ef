"""Zones of hazard maps, as countries define them, from what the runs of all scenarios reach.

switzerland  red: 30 kPa or more with a return period of up to 300 years, or reached at all with up to 30 years; blue:
             reached with more than 30 and up to 300 years, with less than 30 kPa. Richtlinien zur Berücksichtigung der
             Lawinengefahr (BFF and SLF, 1984); the yellow zone, of powder and rare flows, is not computed.
norway       by the expected number of arrivals, the total of all paths: more than 1/5000, 1/1000 and 1/100 a year,
             which the safety classes S3, S2 and S1 of buildings may not exceed. TEK17, § 7-3; it asks for the total of
             all kinds of slides.
"""

from dataclasses import dataclass

import numpy as np

STRONG = 30e3
"""Pressure [Pa] that divides blue and red."""
SHORT, LONG = 30.0, 300.0
"""Return periods [years]."""
NORWEGIAN = (1.0 / 5000.0, 1.0 / 1000.0, 1.0 / 100.0)
"""Largest yearly probabilities of S3, S2 and S1."""


@dataclass(frozen=True)
class Zoning:
    """names and colours of the zones 1, 2, ..."""

    names: tuple
    colours: tuple


ZONES = {
    "switzerland": Zoning(("blue", "red"), ("#4f81d6", "#d63b32")),
    "norway": Zoning(("above 1/5000 a year (not S3)", "above 1/1000 a year (not S2)", "above 1/100 a year (not S1)"),
                     ("#fbe38a", "#f0a03c", "#c8372d")),
}


def zones_of(country, periods, peaks, arrivals):
    """Numbers of the zones (rows, columns), 0 outside of all. periods: return period [years] of each scenario; peaks:
    its peak pressure [Pa], NaN where nothing came; arrivals: expected number [1/year], 0 where nothing comes."""
    found = np.zeros(arrivals.shape, np.uint8)
    if country == "norway":
        # A limit is met by just so much
        return np.searchsorted(NORWEGIAN, arrivals * (1.0 - 1e-6), side="left").astype(np.uint8)
    for period, pressure in zip(periods, peaks, strict=True):
        if period > LONG:
            continue
        reached = np.isfinite(pressure)
        red = reached if period <= SHORT else reached & (pressure >= STRONG)
        found = np.maximum(found, np.where(red, 2, np.where(reached, 1, 0)).astype(np.uint8))
    return found
