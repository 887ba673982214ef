"""Where a simulation lies: the origin that positions are counted from, and the box that is followed."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from snowmpm.annotations import Floats
from snowmpm.errors import InputError
from snowmpm.particles.blocks import EDGE


class Frame:
    """dim, precision, origin (dim,) [m, scene], dx [m]; lower, upper: the domain in cells of dx from the origin."""

    dim: int
    precision: str
    dx: float
    origin: Floats
    lower: Floats
    upper: Floats

    def __init__(self, dim: int, precision: str, origin: ArrayLike, dx: float, lower: ArrayLike,
                 upper: ArrayLike) -> None:
        self.dim, self.precision, self.dx = dim, precision, dx
        self.origin = np.asarray(origin, float)
        self.lower, self.upper = ((np.asarray(bound, float) - self.origin) / dx for bound in (lower, upper))

    def period(self, names: Sequence[Sequence[str]]) -> NDArray[np.int64]:
        """Blocks after which each axis repeats, 0 where it does not, (dim,). Raises InputError when they do not fit."""
        period, edge = np.zeros(self.dim, np.int64), EDGE[self.dim]
        for axis, ends in enumerate(names):
            if "periodic" in ends:
                blocks = (self.upper[axis] - self.lower[axis]) / edge
                if abs(blocks - round(blocks)) > 1e-6 or round(blocks) < 1 or abs(self.lower[axis]) > 1e-9:
                    raise InputError("domain.boundary = periodic: the domain must be a whole number of"
                                     f" {edge * self.dx:g} m ({edge} cells) long, not {blocks * edge * self.dx:g} m")
                period[axis] = round(blocks)
        return period

    def limits(self, period: NDArray[np.int64]) -> tuple[Floats, Floats]:
        """(lower, upper) cells beyond which a particle has left; none along a periodic axis."""
        return np.where(period > 0, -np.inf, self.lower), np.where(period > 0, np.inf, self.upper)

    @property
    def bounds(self) -> Floats:
        """(origin, lower, upper), (3, dim): what a checkpoint must agree with."""
        return np.array([self.origin, self.lower, self.upper])

    def check(self, bounds: ArrayLike) -> None:
        """Raises InputError when a checkpoint's `bounds` are others."""
        if not np.array_equal(self.bounds, bounds):
            raise InputError("the domain is not the checkpoint's: without domain.min and domain.max it follows"
                             " end_time, which then must stay as it was")
