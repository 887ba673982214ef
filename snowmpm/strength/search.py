"""The search for the factor at which a slope begins to slide: up or down until it does, then halves of what is left."""

from collections.abc import Callable
from dataclasses import dataclass, field

from snowmpm.errors import InputError

GROWTH = 1.25
"""From one factor to the next, until one stands and one slides."""


@dataclass(frozen=True)
class Trial:
    """A slope with its strength divided by `factor`, from rest: speed [m/s] that 1 % of it exceed, a mean over the last
    tenth of the time; way [m] that 1 % exceed in all; slides; folder of its run, relative to that of the search."""

    factor: float
    speed: float
    way: float
    slides: bool
    folder: str
    strengths: dict[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class Found:
    """Largest factor found to stand, smallest found to slide, and the trials in the order they were made."""

    stands: float
    slides: float
    trials: list[Trial]

    @property
    def trial(self) -> Trial:
        """The first trial that slides."""
        return next(trial for trial in self.trials if trial.factor == self.slides)


def search(attempt: Callable[[float], Trial], step: float, lowest: float, highest: float) -> Found:
    """Find the factor, a multiple of `step`, between two limits. attempt: makes the trial of a factor.

    Raises InputError where all within the limits stand, or slide.
    """
    made: dict[int, Trial] = {}

    def slides(number: int) -> bool:
        if number not in made:
            made[number] = attempt(round(number * step, 10))
        return made[number].slides

    least, most = max(1, round(lowest / step)), round(highest / step)
    begin = min(max(round(1.0 / step), least), most)
    stands, falls = (None, begin) if slides(begin) else (begin, None)
    while falls is None or stands is None:
        at = stands if falls is None else falls
        if at == (most if falls is None else least):
            word, limit = ("stands", "--to") if falls is None else ("slides", "--from")
            raise InputError(f"{limit} {at * step:g}: it still {word} with its strength divided by that")
        if falls is None:
            at = min(max(at + 1, round(at * GROWTH)), most)
        else:
            at = max(min(at - 1, round(at / GROWTH)), least)
        stands, falls = (stands, at) if slides(at) else (at, falls)
    while falls - stands > 1:
        middle = (stands + falls) // 2
        stands, falls = (stands, middle) if slides(middle) else (middle, falls)
    return Found(round(stands * step, 10), round(falls * step, 10), list(made.values()))
