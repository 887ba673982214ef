"""Forces on parts of the surface of bodies: their tables, and what they do not go with."""

from typing import Annotated, ClassVar, Literal

from pydantic import Field, model_validator

from snowmpm.components.contract import Component
from snowmpm.errors import InputError
from snowmpm.registry import COMPONENTS, FORCES, OBSTACLES
from snowmpm.scenes.forces import Value, Valued
from snowmpm.scenes.space import FileName, Vector
from snowmpm.scenes.spec import Name, Positive, Spec, refuse


class Part(Spec):
    """A block along the axes of the scene, flat where a surface is."""

    min: Vector
    """lower corner [m]"""
    max: Vector
    """upper corner [m]; may be as low as min along an axis"""

    @model_validator(mode="after")
    def _corners(self):
        if any(low > high for low, high in zip(self.min, self.max, strict=False)):
            raise refuse(f"must not be below min = {list(self.min)} along any axis", "max", self.max)
        return self


class _OnFace(Valued):
    """What acts on the surface that a body has at time zero, or on a part of it."""

    name: Name
    """of its columns in the history"""
    body: str
    """name of the body, whose shape is a box, sphere, cylinder, mesh or polygon"""
    within: Part | None = None
    """the part of its surface: that in a block; all of it that does not lie on a side of the domain when missing"""

    def places(self):
        return [f"on the surface of {self.body}", *(["in within"] if self.within else [])]


@FORCES.add
class Traction(_OnFace):
    """A force of fixed direction on a body's own surface."""

    EXAMPLES: ClassVar = {"file": "footing.csv"}

    kind: Literal["traction"]
    value: Annotated[tuple[Value, ...], Field(min_length=2, max_length=3)] | None = None
    """[Pa] over the area at time zero: a number or a formula of x, y, z and t, one an axis"""
    file: FileName | None = None
    """table (.csv) on a grid in space and time, in place of the value: time, x, y, z (those that it depends on), then
    tx, ty, tz"""


@FORCES.add
class FollowerPressure(_OnFace):
    """A pressure on a body's own surface, which stays normal to it as it moves and stretches."""

    EXAMPLES: ClassVar = {"file": "air_bag.csv"}

    kind: Literal["follower_pressure"]
    value: Value | None = None
    """[Pa] over the area now, compression positive: a number or a formula of x, y, z and t"""
    file: FileName | None = None
    """table (.csv) on a grid in space and time, in place of the value: time, x, y, z (those that it depends on), then
    pressure"""


@FORCES.add
class Displacement(_OnFace):
    """A surface of prescribed motion, wherever it cuts the grid, to which a body's own surface is tied by a penalty."""

    EXAMPLES: ClassVar = {"file": "plate.csv"}

    UNIT: ClassVar = "m"
    kind: Literal["displacement"]
    value: Annotated[tuple[Value, ...], Field(min_length=2, max_length=3)] | None = None
    """[m] from the place at time zero: a number or a formula of x, y, z (that place) and t, one an axis"""
    file: FileName | None = None
    """table (.csv) on a grid in space and time, in place of the value: time, x, y, z (those that it depends on), then
    ux, uy, uz"""
    contact: Literal["stick", "slip", "separate"] = "stick"
    """stick: in all directions; slip: along the normal at time zero; separate: the same, but snow is never pulled"""
    penalty: Annotated[Positive, Field(le=1e8)] | None = None
    """stiffness of the tie over that of a cell of the material [-]: the surface gives way as a layer of dx / penalty
    would. When missing 10, which shortens explicit steps to about 0.4, and 1000 with steps that are solved for"""


FACES = (Traction, FollowerPressure, Displacement)


def asked(scene):
    """(key, value) of each force on a surface."""
    for i, force in enumerate(scene.forces):
        if isinstance(force, FACES):
            yield f"forces.{i}.kind", force.kind


def refuse_hollow(scene):
    """Raise InputError for bodies without a surface of their own."""
    for i, force in enumerate(scene.forces):
        if isinstance(force, FACES):
            shape = next(body for body in scene.bodies if body.name == force.body).shape
            if shape.kind not in OBSTACLES:
                raise InputError.at(f"forces.{i}.body", force.body, f'needs a shape of kind {", ".join(OBSTACLES)}, and'
                                    f' has "{shape.kind}"', scene.source)


COMPONENTS.add(Component(
    "face_loads", __package__, "loads on surfaces", asked, order=50,
    beside=("switch", "zone", "water", "initial.from", 'initial.stress = "settle"', "solver.kernel"),
    refuse=refuse_hollow, cautions=f"{__package__}.cautions", atlas=f"{__package__}.atlas"))
