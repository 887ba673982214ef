"""Bodies of material, and obstacles with their motion."""

from typing import Annotated

from pydantic import Field, model_validator

from snowmpm import components
from snowmpm.scenes.shapes import BodyShape, ObstacleShape
from snowmpm.scenes.space import (
    LIST,
    NUMBER,
    FileName,
    Vector,
    by_type,
    check_turn,
    no_rotation,
    zero_vector,
)
from snowmpm.scenes.spec import Name, NonNegative, Number, Positive, Spec, check_period, refuse
from snowmpm.scenes.terrain import Touching


class Body(Spec):
    """A shape filled with a material."""

    name: Name
    """unique among the bodies"""
    material: str
    """name of one of the scene's materials, or of a material card"""
    shape: BodyShape
    """filled with snow"""
    velocity: Vector = Field(default_factory=zero_vector)
    """initial velocity [m/s]"""
    start_time: NonNegative = 0.0
    """when it is released [s]: until then it lies where it is; method = "depth" only"""


components.open_table("bodies", Body)


def _moves(value):
    return any(value) if isinstance(value, tuple) else bool(value)


class Motion(Spec):
    """Rigid motion of an obstacle: uniform from `start` to `stop` and at rest before and after, or from a table."""

    velocity: Vector = Field(default_factory=zero_vector)
    """of the centre [m/s]"""
    angular_velocity: Annotated[
        Annotated[Number, NUMBER] | Annotated[Vector, LIST], by_type(NUMBER, LIST)
    ] = Field(default_factory=no_rotation)
    """[degrees/s]; 2-D: a number, positive from +x towards +z; 3-D: a vector along the axis, right-handed"""
    centre: Vector | None = None
    """initial position of the centre of rotation [m]; the middle of the shape when missing"""
    start: NonNegative = 0.0
    """[s]; of a table: when its time is 0"""
    stop: Positive | None = None
    """[s]; never when missing"""
    ramp: NonNegative = 0.0
    """time in which the speed rises smoothly from 0 after `start`, and falls back to 0 before `stop` [s]"""
    file: FileName | None = None
    """table (.csv) in place of the velocities: time [s], displacement x, y, z [m], angle or, in 3-D, angle_x,
    angle_y, angle_z [degrees]; missing columns are 0"""

    @model_validator(mode="after")
    def _is_one_motion(self):
        given = self.model_fields_set
        if self.file is not None:
            for key in ("velocity", "angular_velocity", "stop", "ramp"):
                # Defaults, which a resolved scene writes out, do not count as given
                if key in given and _moves(self[key]):
                    raise refuse("does not go with file, which says all about the motion", key, self[key])
        elif not given & {"velocity", "angular_velocity"}:
            raise refuse("needs velocity, angular_velocity or file")
        return self

    @model_validator(mode="after")
    def _turns_in_its_plane(self):
        check_turn(self.angular_velocity)
        return self

    @model_validator(mode="after")
    def _ends_after_it_starts(self):
        check_period(self.start, self.stop)
        if self.stop is not None and 2.0 * self.ramp > self.stop - self.start:
            raise refuse(f"must be at most half of the time from start to stop, {self.stop - self.start:g}", "ramp",
                         self.ramp)
        return self


class Obstacle(Touching):
    """A rigid solid in contact with snow."""

    name: Name
    """unique among the obstacles"""
    shape: ObstacleShape
    """solid"""
    on_ground: Annotated[bool, Field(strict=True)] = False
    """put down on the terrain: its lowest point is then at the height of the lowest ground under it; else as drawn"""
    motion: Motion | None = None
    """at rest when missing"""
    drag: Positive = 2.0
    """c_d of the pressure c_d density v^2 / 2 of a depth-averaged flow [-]: 2 for walls, 1 to 1.5 for masts"""


components.open_table("obstacles", Obstacle)
