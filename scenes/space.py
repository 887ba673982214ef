"""Vectors, plan positions and file names of a scene: checked against its dimension and its folder.

A vector must have as many components as the scene has axes, and a file must lie where the scene says. Both facts lie
outside the value, so `Scene` provides them here during validation; a table validated on its own accepts any.
"""

import contextlib
from contextvars import ContextVar
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

from pydantic import AfterValidator, BaseModel, Discriminator, Field, Tag

from snowmpm.errors import nearest_file
from snowmpm.scenes.spec import Number, refuse


def tag(name: str) -> str:
    """Mark of a union member in an error's location, which no key of a scene can be equal to."""
    return f"<{name}>"


NUMBER, TEXT, LIST, TABLE = (Tag(tag(name)) for name in ("number", "text", "list", "table"))
"""Marks of a union's members for `by_type`."""

AXES = {2: ("x", "z"), 3: ("x", "y", "z")}


@dataclass(frozen=True)
class Surroundings:
    """Facts outside a value on which its validation depends."""

    dimension: int | None = None  # 2, 3, or None: not known (yet)
    base_dir: Path | None = None  # folder that file names are relative to, or None: files are not looked for


NOWHERE = Surroundings()
_surroundings = ContextVar("surroundings", default=NOWHERE)


@contextlib.contextmanager
def surroundings(dimension=None, base_dir=None):
    """Context: validation for this dimension and folder; arguments that are not given keep their value."""
    known = _surroundings.get()
    token = _surroundings.set(Surroundings(dimension or known.dimension, base_dir or known.base_dir))
    try:
        yield
    finally:
        _surroundings.reset(token)


def dimension():
    """Axes of the scene under validation: 2, 3, or None outside a scene."""
    return _surroundings.get().dimension


def base_dir():
    """Folder that file names of the scene under validation are relative to; None outside a scene file."""
    return _surroundings.get().base_dir


def require_dimension(wanted, what):
    """Raise an error for `what` (text of the message) unless the scene has `wanted` axes."""
    if dimension() not in (wanted, None):
        raise refuse(f"{what} exists only in a {wanted}-D scene, and this one has dimension = {dimension()}")


def _check_vector(value):
    axes = AXES.get(dimension())
    if axes is not None and len(value) != len(axes):
        raise refuse(f"must be {len(axes)} numbers, [{', '.join(axes)}], in a {dimension()}-D scene")
    return value


def _check_interval(value):
    if value[0] >= value[1]:
        raise refuse("must be [lower, upper] with lower < upper")
    return value


def _check_direction(value):
    if not any(value):
        raise refuse("must not be zero in every component")
    return value


def check_file(value, key=None):
    """The name of a file that exists, or an error; key: its place below the table under validation, if the name is not
    the value under validation itself."""
    place = {"key": key, "value": value} if key else {}
    if not value or "\0" in value:
        raise refuse("must be the name of a file", **place)
    base_dir = _surroundings.get().base_dir
    if base_dir is not None and not (path := base_dir / Path(value).expanduser()).is_file():
        raise refuse(f"no such file (looked for {path}, from the scene's folder){nearest_file(path)}", **place)
    return value


def zero_vector():
    """As many zeros as the scene has axes."""
    return (0.0,) * (dimension() or 3)


Vector = Annotated[tuple[Number, ...], Field(min_length=2, max_length=3), AfterValidator(_check_vector)]
Direction = Annotated[Vector, AfterValidator(_check_direction)]
Pair = tuple[Number, Number]
Interval = Annotated[Pair, AfterValidator(_check_interval)]
FileName = Annotated[str, Field(strict=True), AfterValidator(lambda value: check_file(value))]


def by_type(*branches: Tag) -> Discriminator:
    """What selects the member of a union by the TOML type of the value, so that messages concern one member only.

        Annotated[Annotated[Number, NUMBER] | Annotated[Vector, LIST], by_type(NUMBER, LIST)]

    branches: marks of the members. A value of any other type is validated as the first.
    """

    def branch(value: Any) -> str:
        kinds = {
            TABLE: isinstance(value, dict | BaseModel),
            LIST: isinstance(value, list | tuple),
            TEXT: isinstance(value, str),
            NUMBER: isinstance(value, int | float),
        }
        return next((mark for mark in branches if kinds[mark]), branches[0]).tag

    return Discriminator(branch)


def no_rotation() -> float | tuple[float, ...]:
    """Angular velocity 0 in the dimension of the scene."""
    return 0.0 if dimension() == 2 else zero_vector()


def check_turn(omega: object) -> None:
    """Raise an error unless an angular velocity suits the dimension of the scene."""
    if dimension() == 2 and isinstance(omega, tuple):
        raise refuse("must be a number [degrees/s] in a 2-D scene", "angular_velocity", omega)
    if dimension() == 3 and not isinstance(omega, tuple):
        raise refuse("must be 3 numbers, [x, y, z] [degrees/s], in a 3-D scene", "angular_velocity", omega)
