"""Parameters of a campaign: a key of the scene, and how its value is distributed.

Each has `quantile(u)`: the value below which the share u of all values lies (inverse distribution function). A design
is made of shares, so that it knows no distributions.
"""

import json
import math
from collections.abc import Callable
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import Field, model_validator
from pydantic.json_schema import SkipJsonSchema
from scipy.special import ndtr, ndtri

from snowmpm.annotations import Floats
from snowmpm.scenes.spec import Number, Positive, Spec, refuse

DIGITS = 9
"""Significant digits of a value: it is the same after it was written as text."""

Key = Annotated[str, Field(strict=True, min_length=1, max_length=200)]
Title = Annotated[str, Field(strict=True, min_length=1, max_length=60, pattern=r"^[^\x00-\x1f\x7f]+$")]
Whole = Annotated[int, Field(strict=True, ge=2, le=10_000)]


class Parameter(Spec):
    """key: dotted key of the scene as `--set` takes it, or a list of keys that get the same value."""

    key: Key | Annotated[tuple[Key, ...], Field(min_length=1)]
    """key of the scene, or several that get the same value"""
    levels: Whole = 5
    """values of it in a grid, and one at a time"""

    @property
    def keys(self) -> tuple[str, ...]:
        return (self.key,) if isinstance(self.key, str) else self.key

    @property
    def bounded(self) -> bool:
        """Whether shares 0 and 1 have values."""
        return True

    def shares(self) -> Floats:
        """Shares of the values of a grid: the ends included where there are any."""
        n = self.levels
        return np.arange(n) / (n - 1.0) if self.bounded else (np.arange(n) + 0.5) / n

    def test(self) -> Callable[[Any], bool]:
        """Function that tells whether a value, as read from a file, may be one of it."""
        return lambda value: (isinstance(value, int | float) and not isinstance(value, bool)
                              and math.isfinite(value))

    def changes(self, value: Any) -> dict[str, Any]:
        """Changes of the scene, by key, that a value means."""
        return dict.fromkeys(self.keys, value)

    def quantile(self, u: float) -> Any:
        """Value at the share u, from 0 to 1."""
        value = float(self._quantile(u))
        return float(f"{value:.{DIGITS - 1}e}")

    def share(self, value: float) -> float:
        """Share of the values below this one: the inverse of `quantile`."""
        return min(max(float(self._share(value)), 0.0), 1.0)

    def _quantile(self, u):
        raise NotImplementedError

    def _share(self, value):
        raise NotImplementedError


class Uniform(Parameter):
    """Every value from low to high is as likely."""

    distribution: Literal["uniform"] = "uniform"
    low: Number
    """least value"""
    high: Number
    """largest value"""

    @model_validator(mode="after")
    def _ordered(self):
        if self.high <= self.low:
            raise refuse(f"must be above low = {self.low:g}", "high", self.high)
        return self

    def _quantile(self, u):
        return self.low + u * (self.high - self.low)

    def _share(self, value):
        return (value - self.low) / (self.high - self.low)


class Cut(Parameter):
    """A distribution that may be cut off: only values from low to high occur."""

    low: Number | None = None
    """least value; none when missing"""
    high: Number | None = None
    """largest value; none when missing"""

    @property
    def bounded(self) -> bool:
        return self.low is not None and self.high is not None

    def _check(self):
        if self.low is not None and self.high is not None and self.high <= self.low:
            raise refuse(f"must be above low = {self.low:g}", "high", self.high)
        begin, end = self._ends()
        if end - begin < 1e-6:
            raise refuse("less than one value in a million lies between low and high", "low", self.low)
        return self

    def _ends(self):
        return (0.0 if self.low is None else float(ndtr(self._score(self.low))),
                1.0 if self.high is None else float(ndtr(self._score(self.high))))

    def _quantile(self, u):
        begin, end = self._ends()
        tiny = np.finfo(float).eps
        value = self._at(float(ndtri(min(max(begin + u * (end - begin), tiny), 1.0 - tiny))))
        low, high = (-math.inf if self.low is None else self.low), (math.inf if self.high is None else self.high)
        return min(max(value, low), high)

    def _share(self, value):
        begin, end = self._ends()
        return (float(ndtr(self._score(value))) - begin) / (end - begin)

    def _score(self, value):
        """Normal score of a value."""
        raise NotImplementedError

    def _at(self, score):
        """Value of a normal score."""
        raise NotImplementedError


class Normal(Cut):
    """The normal distribution of this mean and standard deviation, cut off at low and high."""

    distribution: Literal["normal"]
    mean: Number
    """mean before it is cut off"""
    deviation: Positive
    """standard deviation before it is cut off"""

    @model_validator(mode="after")
    def _possible(self):
        return self._check()

    def _score(self, value):
        return (value - self.mean) / self.deviation

    def _at(self, score):
        return self.mean + self.deviation * score


class LogNormal(Cut):
    """The logarithm is normally distributed: 68 % of the values lie from median / factor to median * factor."""

    EXAMPLES: ClassVar = {"low": 800.0, "high": 3000.0}

    distribution: Literal["lognormal"]
    median: Positive
    """half of the values lie below it"""
    factor: Annotated[Number, Field(gt=1.0)]
    """one standard deviation, as a factor"""

    @model_validator(mode="after")
    def _possible(self):
        for name in ("low", "high"):
            if (value := self[name]) is not None and value <= 0.0:
                raise refuse("must be > 0: all values are", name, value)
        return self._check()

    def _score(self, value):
        return math.log(value / self.median) / math.log(self.factor)

    def _at(self, score):
        return self.median * self.factor**score


class Choices(Parameter):
    """One of several values: numbers, words, files; each as likely, or with weights."""

    EXAMPLES: ClassVar = {"values": [0.19, 0.25, 0.32], "weights": [1.0, 2.0, 1.0]}

    distribution: Literal["choices"]
    values: Annotated[tuple[Any, ...], Field(min_length=1, max_length=10_000)]
    """values that it may have"""
    weights: Annotated[tuple[Positive, ...], Field(min_length=1)] | None = None
    """how likely each is, to a common factor"""

    @model_validator(mode="after")
    def _as_many(self):
        if self.weights is not None and len(self.weights) != len(self.values):
            raise refuse(f"must be {len(self.values)} numbers, one a value", "weights", self.weights)
        return self

    def test(self) -> Callable[[Any], bool]:
        known = set(map(json.dumps, self.values))
        return lambda value: json.dumps(value) in known

    def _steps(self):
        weights = np.asarray(self.weights or np.ones(len(self.values)), float)
        return np.concatenate([[0.0], np.cumsum(weights) / weights.sum()])

    def shares(self) -> Floats:
        steps = self._steps()
        return 0.5 * (steps[1:] + steps[:-1])

    def quantile(self, u: float) -> Any:
        at = int(np.searchsorted(self._steps()[1:-1], u, side="right"))
        return self.values[at]


class Scenarios(Choices):
    """Named scenarios, each of which changes several keys of the scene, such as those of a return period."""

    EXAMPLES: ClassVar = {"sets": {"10 years": {"bodies.0.shape.top": 0.8, "terrain.friction.card": "samos_at_small"},
                                   "100 years": {"bodies.0.shape.top": 1.4}}}

    distribution: Literal["scenarios"]  # type: ignore[assignment]
    key: SkipJsonSchema[Annotated[tuple[Key, ...], Field(exclude=True)]] = ()
    values: SkipJsonSchema[Annotated[tuple[str, ...], Field(exclude=True)]] = ()
    weights: SkipJsonSchema[Annotated[None, Field(exclude=True)]] = None
    sets: Annotated[dict[Title, Annotated[dict[Key, Any], Field(min_length=1)]], Field(min_length=1, max_length=100)]
    """changes of the scene by the name of the scenario, as of `--set`"""

    @model_validator(mode="before")
    @classmethod
    def _named(cls, given: Any) -> Any:
        if not isinstance(given, dict):
            return given
        for name in ("key", "values"):
            if name in given:
                raise refuse("does not go with distribution = \"scenarios\", whose sets name keys and values", name,
                             given[name])
        sets = given.get("sets")
        return given | {"values": tuple(sets)} if isinstance(sets, dict) else given

    @property
    def keys(self) -> tuple[str, ...]:
        return tuple(dict.fromkeys(key for one in self.sets.values() for key in one))

    def changes(self, value: Any) -> dict[str, Any]:
        return self.sets[value]


class Drawn(Parameter):
    """A row of a table of samples, such as a posterior: parameters of one file take the same row."""

    EXAMPLES: ClassVar = {"file": "posterior.csv", "column": "mu"}

    distribution: Literal["posterior"]
    file: Annotated[str, Field(strict=True, min_length=1)]
    """posterior.csv of a calibration, relative to the campaign's file"""
    column: Annotated[str, Field(strict=True, min_length=1)] | None = None
    """of the file; the parameter's name when missing"""


AnyParameter = Annotated[Uniform | Normal | LogNormal | Choices | Scenarios | Drawn,
                         Field(discriminator="distribution")]
