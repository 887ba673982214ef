"""What depth-averaging changes, from the table of `tests/benchmarks/depth_against_mpm.py`."""

import csv
import functools
from pathlib import Path

from snowmpm.quantities.table import quantity

TABLE = Path(__file__).with_name("depth_averaged.csv")
SAID = ("runout", "largest_flow_speed", "largest_flow_pressure", "largest_flow_depth", "affected_area", "deposit_area")
"""Quantities of a sentence, in its order."""


@functools.cache
def differences():
    """{quantity: depth-averaged over three-dimensional, less 1}."""
    with open(TABLE, newline="", encoding="utf-8") as file:
        rows = {row["quantity"]: row for row in csv.DictReader(file)}
    return {name: float(row["depth"]) / float(row["mpm"]) - 1.0 for name, row in rows.items()}


def in_words():
    """What differs, and by how much."""
    found = differences()
    return ", ".join(f"{quantity(name).label} {100.0 * found[name]:+.0f} %" for name in SAID)
