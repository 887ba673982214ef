"""Reference solution of a scene, from an experiment or a formula, for `snowmpm compare`.

A scene names only the kind of reference; sizes, load and material are those of its first body.
`snowmpm.comparison.answers` has the reference solutions and their sources.
"""

from typing import Annotated, Literal

from pydantic import Field

from snowmpm.scenes.space import Pair
from snowmpm.scenes.spec import Number, Spec


class PlaneColumn(Spec):
    """A column of grains collapses in plane strain: final run-out and height, measured."""

    kind: Literal["plane_column"]
    centre: Number = 0.0
    """x of the middle of the column [m]; its half-width is from there to the end of the box"""


class RoundColumn(Spec):
    """A round column of grains collapses: final run-out and height, measured."""

    kind: Literal["round_column"]
    centre: Pair = (0.0, 0.0)
    """of the column in plan [m]"""


class Cantilever(Spec):
    """A straight elastic beam, clamped at its end of small x, is released under its weight: motion of the other end."""

    kind: Literal["cantilever"]


class Oedometer(Spec):
    """A sample between smooth walls is pressed by a piston from above: stresses against strain, exact."""

    kind: Literal["oedometer"]
    piston: str
    """name of the obstacle that is the piston"""


class WallThrust(Spec):
    """Grains at rest on a bed against a wall normal to it: bounds of their thrust, by Coulomb's wedges."""

    kind: Literal["wall_thrust"]
    wall: str
    """name of the obstacle that they lean against, its face looking towards small x"""
    bed: str
    """name of the obstacle that they lie on, its face looking up"""


class SlopeStability(Spec):
    """A soil slope: its factor of safety by slices on slip circles."""

    kind: Literal["slope_stability"]


Reference = Annotated[PlaneColumn | RoundColumn | Cantilever | Oedometer | WallThrust | SlopeStability,
                      Field(discriminator="kind")]

OF_SPACE = ("round_column",)
"""Kinds for 3-D scenes; all others are for 2-D scenes."""
