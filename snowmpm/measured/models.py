"""What each model misses of an answer, from the table of `snowmpm study models`.

The error of a rung in a problem is e = ln(answer / reference). Over n problems it has a mean b and a standard deviation
s; the reference itself is known to u. The error in another problem then lies in

    b ± t sqrt(s² (1 + 1/n) + u²),   t of Student's distribution with n - 1 degrees of freedom,

in nine of ten. Of questions that are answered by yes or no the error is the chance to be wrong, (k + 1) / (n + 2) with
k of n answers wrong.
"""

import functools
import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from snowmpm.reading.table_file import read_table

TABLE = Path(__file__).with_name("models.csv")
COLUMNS = ("problem", "question", "rung", "value", "reference", "unsure", "seconds", "forecast", "yes_no")
SHARE = 0.9
"""Of answers that lie within the interval."""
TENFOLD = 10.0
"""Relative error from which on only its order is told."""
LIKELY, HALF, TWICE = 1.0 / 3.0, -0.5, 1.0
"""Chance to be wrong, and relative errors, from which on an answer is not worth its time."""
LEAST = 3
"""Problems from which an error is known."""
MISSED = 0.01
"""An answer below this share of the reference counts as this share: the model has missed it."""


@dataclass(frozen=True)
class Row:
    """One answer. reference: what it is held against; unsure: to what share that is known; seconds, forecast: processor
    time of the whole command, and what was told before [s]; yes_no: whether the answer is one of two."""

    problem: str
    question: str
    rung: str
    value: float
    reference: float
    unsure: float
    seconds: float
    forecast: float
    yes_no: bool = False

    @property
    def error(self):
        """ln(value / reference); of yes and no 1 where it is wrong."""
        if self.yes_no:
            return float(self.value != self.reference)
        return math.log(max(self.value / self.reference, MISSED))


@dataclass(frozen=True)
class Expected:
    """low, high: relative errors between which nine of ten answers lie; n: problems. Of yes and no both are the chance
    to be wrong."""

    low: float
    high: float
    n: int
    yes_no: bool = False

    @property
    def error(self):
        """The larger of the two."""
        return max(abs(self.low), abs(self.high))

    @property
    def tells(self):
        """Whether an answer with this error is worth its time."""
        return self.error < LIKELY if self.yes_no else self.low > HALF and self.high < TWICE

    @property
    def words(self):
        """For reading: an interval, or a chance."""
        if self.yes_no:
            return f"wrong in {self.low:.0%} of cases"
        return f"{self.low:+.0%} to " + (f"{self.high:+.0%}" if self.high < TENFOLD else "ten times and more")


def expected_of(rows):
    """`Expected` of the answers of one rung to one question; None from fewer than `LEAST` problems."""
    n = len(rows)
    if n < LEAST:
        return None
    errors = np.array([row.error for row in rows])
    if rows[0].yes_no:
        wrong = (errors.sum() + 1.0) / (n + 2.0)
        return Expected(float(wrong), float(wrong), n, yes_no=True)
    from scipy.special import stdtrit  # quantiles of Student's distribution; scipy.stats takes half a second

    unsure = float(np.mean([row.unsure**2 for row in rows]))
    half = stdtrit(n - 1, 0.5 + 0.5 * SHARE) * math.sqrt(errors.var(ddof=1) * (1.0 + 1.0 / n) + unsure)
    return Expected(math.expm1(errors.mean() - half), math.expm1(min(errors.mean() + half, MOST)), n)


MOST = math.log(1e3)
"""Largest ln of a ratio that is told."""


def read(path):
    """`Row`s of a table. Raises InputError."""
    return read_table(Path(path), lambda row: Row(
        row["problem"], row["question"], row["rung"],
        *(float(row[name]) for name in ("value", "reference", "unsure", "seconds", "forecast")),
        row["yes_no"] == "yes"))


@functools.cache
def shipped():
    """`Row`s of the table that ships with the program."""
    return tuple(read(TABLE)) if TABLE.exists() else ()


def rows_of(question, rung, without=()):
    """Shipped `Row`s of a rung and a question. without: names of problems to leave out."""
    return [row for row in shipped() if row.question == question and row.rung == rung and row.problem not in without]


def seconds_of(rung):
    """Median of the processor time of a model without a run [s]; None where it was never measured."""
    found = [row.seconds for row in shipped() if row.rung == rung]
    return float(np.median(found)) if found else None
