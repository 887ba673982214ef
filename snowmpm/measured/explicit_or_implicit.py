"""What explicit and implicit steps cost for the same error, from the table of
`tests/benchmarks/explicit_or_implicit.py`."""

import csv
import functools
from pathlib import Path

TABLE = Path(__file__).with_name("explicit_or_implicit.csv")
METHODS = ("explicit", "implicit")


@functools.cache
def rows():
    """Rows of the table, with numbers."""
    with open(TABLE, newline="", encoding="utf-8") as file:
        return [{key: value if key in ("case", "method") else float(value) for key, value in row.items()}
                for row in csv.DictReader(file)]


def cheapest(case, method, error):
    """The row of a case with the fewest seconds whose error is at most `error`; None where there is none."""
    found = [row for row in rows() if (row["case"], row["method"]) == (case, method) and row["error"] <= error]
    return min(found, key=lambda row: row["seconds"], default=None)


def at_equal_error(case):
    """(error, explicit seconds, implicit seconds): the smallest error that both reach, and what it takes at least."""
    error = max(min(row["error"] for row in rows() if (row["case"], row["method"]) == (case, method))
                for method in METHODS)
    return (error, *(cheapest(case, method, error)["seconds"] for method in METHODS))


def in_words(case):
    """What a case took for an equal error."""
    error, explicit, implicit = at_equal_error(case)
    return (f"{case.replace('_', ' ')}, to {100.0 * error:.2g} %: explicit {explicit:.2g} s, implicit {implicit:.2g} s")
