"""Structures that bend in the snow: what all say, masts, and how kinds of structures are told apart."""

from typing import Annotated, Any, ClassVar, Literal, Union

from pydantic import Discriminator, Field, Tag, model_validator

from snowmpm.scenes.space import Vector, dimension, tag
from snowmpm.scenes.spec import Fraction, Name, NonNegative, Positive, refuse
from snowmpm.scenes.terrain import Touching

MOST = 128
"""Segments of a structure."""


KINDS: dict[str, type[Touching]] = {}
"""Tables that a structure may be, by their marks: each has KEYS, one of which tells it from the others (none: the first
one), MAKES, "module:name" of (scene, number) -> what `rods.Rods` asks of a rod, and OWN, whether snowmpm computes
it."""


def kind(mark: str) -> Any:
    """Add a table to KINDS."""
    def added(table: type[Touching]) -> type[Touching]:
        KINDS[mark] = table
        return table
    return added


def _mark_of(value: Any) -> str:
    """Mark of what a table, or what was made of one, is."""
    keys = value if isinstance(value, dict) else ()
    return tag(next((mark for mark, table in KINDS.items()
                     if isinstance(value, table) or any(key in keys for key in table.KEYS)), next(iter(KINDS))))


class AnyKind:
    """Pydantic's schema of a table that is one of KINDS."""

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> Any:
        members = Union[tuple(Annotated[table, Tag(tag(mark))] for mark, table in KINDS.items())]  # noqa: UP007
        return handler.generate_schema(Annotated[members, Discriminator(_mark_of)])


class Bending(Touching):
    """What all structures that snowmpm computes say: round tubes, in 2-D plates, of one material."""

    OWN: ClassVar = True
    name: Name
    """unique among the structures; the history's columns begin with it"""
    width: Positive
    """outer diameter; 2-D: thickness of the plate [m]"""
    wall: Positive | None = None
    """thickness of the tube, 3-D only; a full bar when missing [m]"""
    youngs_modulus: Positive
    """E [Pa]"""
    density: Positive
    """of its material [kg/m3]"""
    yield_stress: Positive | None = None
    """where the whole section yields [Pa]; it does not when missing"""
    hardening: NonNegative = 0.0
    """stiffness of a part that yields over the elastic one [-]"""
    strength: Positive | None = None
    """stress of the outermost fibre, of bending and in frameworks of pull or push, at which it breaks for good [Pa]; it
    does not when missing"""
    damping: Fraction = 0.01
    """share of the critical damping of its first mode [-]"""
    coupling: Literal["weak", "strong", "one_way"] = "weak"
    """weak: the snow meets it as it is bent; strong: with its mean velocity over the step, so that it may
    be lighter than the snow around it; one_way: as it stood at the start"""


@kind("mast")
class Structure(Bending):
    """A mast, post or wall that stands clamped on its foot, and bends: a round tube, in 2-D a plate."""

    KEYS: ClassVar = ()
    MAKES: ClassVar = f"{__package__}.from_scene:mast"
    foot: Vector
    """where it is clamped [m]"""
    top: Vector
    """its free end [m]"""
    segments: Annotated[int, Field(strict=True, ge=2, le=32)] = 8
    """straight pieces"""

    @model_validator(mode="after")
    def _is_slender(self):
        length = sum((a - b) ** 2 for a, b in zip(self.foot, self.top, strict=True)) ** 0.5
        if length < 3.0 * self.width * (1.0 - 1e-9):
            raise refuse(f"must be at most a third of the length, {length:g}: it bends as a slender beam", "width",
                         self.width)
        return self

    @model_validator(mode="after")
    def _has_a_wall(self):
        if self.wall is not None and dimension() == 2:
            raise refuse("is for tubes, in 3-D scenes", "wall", self.wall)
        if self.wall is not None and self.wall > 0.5 * self.width:
            raise refuse(f"must be at most half of width, {0.5 * self.width:g}", "wall", self.wall)
        return self
