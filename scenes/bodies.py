"""What moves and what stands in the way."""

from pydantic import Field, model_validator

from snowmpm.scenes.shapes import BodyShape, ObstacleShape
from snowmpm.scenes.space import Vector, zero_vector
from snowmpm.scenes.spec import Name, NonNegative, Positive, Spec, refuse
from snowmpm.scenes.terrain import Touching


class Body(Spec):
    """A shape filled with a material."""

    name: Name
    material: str
    """name of one of the scene's materials, or of a material card"""
    shape: BodyShape
    velocity: Vector = Field(default_factory=zero_vector)
    """initial velocity [m/s]"""


class Motion(Spec):
    """Uniform motion from `start` to `stop`; at rest before and after."""

    velocity: Vector
    """[m/s]"""
    start: NonNegative = 0.0
    """[s]"""
    stop: Positive | None = None
    """[s]; never when missing"""

    @model_validator(mode="after")
    def _ends_after_it_starts(self):
        if self.stop is not None and self.stop <= self.start:
            raise refuse(f"must be after start = {self.start:g}", "stop", self.stop)
        return self


class Obstacle(Touching):
    """A rigid solid that snow meets."""

    name: Name
    shape: ObstacleShape
    motion: Motion | None = None
    """at rest when missing"""
