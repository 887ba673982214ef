"""Obstacles with mass, which weight, snow and contact move: their table, and what they do not go with."""

from typing import Annotated, ClassVar

from pydantic import Field, model_validator

from snowmpm.components.contract import Component
from snowmpm.errors import InputError
from snowmpm.registry import COMPONENTS
from snowmpm.scenes.space import LIST, NUMBER, Vector, by_type, check_turn, no_rotation, zero_vector
from snowmpm.scenes.spec import Fraction, NonNegative, Number, Positive, Spec, refuse


class Free(Spec):
    """A rigid body that weight, snow and contact move."""

    EXAMPLES: ClassVar = {"mass": 2000.0}

    density: Positive | None = None
    """[kg/m3]; or mass"""
    mass: Positive | None = None
    """its mass [kg], per metre of width in 2-D; or density"""
    velocity: Vector = Field(default_factory=zero_vector)
    """initial velocity of its centre of mass [m/s]"""
    angular_velocity: Annotated[
        Annotated[Number, NUMBER] | Annotated[Vector, LIST], by_type(NUMBER, LIST)
    ] = Field(default_factory=no_rotation)
    """initial [degrees/s]; 2-D: a number, positive from +x towards +z; 3-D: a vector along the axis, right-handed"""
    friction: NonNegative = 0.5
    """Coulomb coefficient against ground, sides, obstacles and other free bodies, the smaller of two; that against snow
    is the obstacle's own [-]"""
    restitution: Fraction = 0.0
    """speed after over speed before an impact on these [-]"""
    start: NonNegative = 0.0
    """held in its place until then [s]"""

    @model_validator(mode="after")
    def _has_one_mass(self):
        if self.density is None and self.mass is None:
            raise refuse("needs density or mass")
        if self.density is not None and self.mass is not None:
            raise refuse("does not go with mass: give one of them", "density", self.density)
        return self

    @model_validator(mode="after")
    def _turns_in_its_plane(self):
        check_turn(self.angular_velocity)
        return self


class OfObstacle(Spec):
    """Keys of an obstacle."""

    free: Free | None = None
    """mass of a body that weight, snow and contact move, in place of motion"""


def asked(scene):
    """(key, value) of each obstacle that is one."""
    for i, obstacle in enumerate(scene.obstacles):
        if obstacle.free:
            yield f"obstacles.{i}.free", "a table"


def refuse_given_motion(scene):
    """Raise InputError for a body with mass whose motion is given."""
    for i, obstacle in enumerate(scene.obstacles):
        if obstacle.free and obstacle.motion:
            raise InputError.at(f"obstacles.{i}.free", "a table", "does not go with motion, which says where it is",
                                scene.source)


COMPONENTS.add(Component(
    "rigid_bodies", __package__, "rigid bodies with mass", asked, order=80, keys={"obstacles": OfObstacle},
    beside=("switch", "periodic sides of the domain"), refuse=refuse_given_motion, moves_on=True, in_python=True,
    motion=f"{__package__}.from_scene:motion_of", cautions=f"{__package__}.cautions", atlas=f"{__package__}.atlas"))
