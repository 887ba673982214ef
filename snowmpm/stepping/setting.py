"""Where a solver steps, and with what around it: what a method takes of a scene, by name (`methods.MethodEntry`)."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from snowmpm.particles.coordinates import Frame


@dataclass(frozen=True)
class Setting:
    """dx [m]; precision "f32" or "f64"; lower, upper, origin (dim,): the domain, and the place of grid node 0, by
    default its lower corner, scene coordinates [m]; gravity (dim,) [m/s2].

    cfl: share of a cell that a wave or a particle may cross in a step, by default the method's usual one. terrain:
    object with `query(points) -> distance, normal` in scene coordinates, or None; of methods in plan a surface with
    `height`. terrain_contact: a name of `contact.CODES`; terrain_friction: Coulomb mu [-]. sides: (dim, 2) names of
    `contact.CODES`, "open" by default, or "periodic" at both ends of an axis, whose length must be a whole number of
    blocks (8 cells in 2-D, 4 in 3-D). obstacles: `solids.Obstacle`s. adapters: of the components at work. expected: how
    many particles there will be, of a solver that receives some.
    """

    dx: float
    precision: str
    lower: Any
    upper: Any
    gravity: Any
    origin: Any = None
    cfl: float | None = None
    terrain: Any = None
    terrain_contact: str = "stick"
    terrain_friction: Any = 0.0
    sides: Any = None
    obstacles: Sequence[Any] = ()
    adapters: Sequence[Any] = ()
    expected: int = 0

    @property
    def dim(self) -> int:
        return len(self.lower)

    @property
    def walls(self) -> Any:
        """Names of what stands at the sides, (dim, 2)."""
        return self.sides or [["open", "open"]] * self.dim

    @property
    def ground(self) -> tuple[Any, str, float] | None:
        """Terrain, its contact and its friction; None without one."""
        return None if self.terrain is None else (self.terrain, self.terrain_contact, self.terrain_friction)

    def frame(self, kind: type[Any] = Frame) -> Any:
        """`Frame` of the domain, or one of a kind of it."""
        origin = self.lower if self.origin is None else self.origin
        return kind(self.dim, self.precision, np.asarray(origin, float), self.dx, self.lower, self.upper)
