"""Share of the snow that still moves, and the definition of rest for the whole program.

    moving_share    mass faster than MOVING_SPEED / mass in the domain
    total_momentum  sum m |v|  [kg m/s]
    momentum_share  total_momentum / its largest value so far; 0 while the mean speed is below CREEP

Snow is at rest when moving_share <= REST_SHARE and momentum_share <= REST_MOMENTUM, or momentum_share <= FILMS. Of
the first two, either alone misleads: a small branch that still runs at 25 m/s has little momentum, and a deposit that
creeps as a whole has no mass above 1 m/s. The momentum rule is the stop criterion of RAMMS (its default is 5 % of the
largest total momentum). The last is for films that drain from steep ground for minutes: the fiftieth of the snow which
may still move has as much momentum at half the mean speed of the flow. CREEP keeps the noise of a slope that never
moved from looking like motion.

A stop criterion must also check `has_moved`: before a release everything is at rest.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

MOVING_SPEED = 1.0
"""Speed above which snow counts as moving [m/s]."""

REST_SHARE = 0.02
"""Largest moving share of snow at rest."""

REST_MOMENTUM = 0.05
"""Largest total momentum, over its peak, of snow at rest."""

FILMS = 0.01
"""Total momentum, over its peak, of snow of which only films still move."""

CREEP = 0.01
"""Mean speed below which nothing has moved, or everything has come to rest [m/s]."""


@dataclass(frozen=True)
class Motion:
    """The motion at one time.

    mass [kg] in the domain; moving_share of it; total_momentum [kg m/s]; peak_momentum: its largest so far, this time
    included.
    """

    mass: float
    moving_share: float
    total_momentum: float
    peak_momentum: float

    @classmethod
    def of(cls, mass: ArrayLike, velocity: ArrayLike, peak: float = 0.0, laid: float = 0.0) -> "Motion":
        """Of particles: mass (n,) [kg], velocity (n, dim) [m/s]; peak: the largest total momentum before [kg m/s];
        laid: mass that rests beside them [kg]."""
        velocity = np.asarray(velocity, np.float64)
        speed = np.sqrt(np.einsum("ij,ij->i", velocity, velocity))
        mass = np.asarray(mass, np.float64)
        total, momentum = float(mass.sum()) + laid, float((mass * speed).sum())
        share = float(mass[speed > MOVING_SPEED].sum()) / total if total > 0.0 else 0.0
        return cls(total, share, momentum, max(float(peak), momentum))

    @property
    def momentum_share(self) -> float:
        """Total momentum over its largest value so far; 0 while the mean speed is below CREEP."""
        return self.total_momentum / self.peak_momentum if self.total_momentum > CREEP * self.mass else 0.0

    @property
    def has_moved(self) -> bool:
        """Whether the mean speed has ever been above CREEP."""
        return self.peak_momentum > CREEP * self.mass

    @property
    def at_rest(self) -> bool:
        """Whether the snow is at rest; also before it has moved."""
        return bool(at_rest(self.moving_share, self.momentum_share))

    def row(self) -> dict[str, float]:
        """The numbers of the history, by name."""
        return {"moving_share": self.moving_share, "total_momentum": self.total_momentum,
                "momentum_share": self.momentum_share}


def at_rest(moving_share, momentum_share):
    """Whether snow is at rest, from numbers or arrays of the history."""
    slow = (np.asarray(moving_share) <= REST_SHARE) & (np.asarray(momentum_share) <= REST_MOMENTUM)
    return slow | (np.asarray(momentum_share) <= FILMS)
