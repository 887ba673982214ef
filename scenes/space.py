"""Vectors, plan positions and file names of a scene: checked against its dimension and its folder.

A vector must have as many components as the scene has axes, and a file must lie where the scene says. Both facts lie
outside the value, so `Scene` provides them here during validation; a table validated on its own accepts any.
"""

import contextlib
from contextvars import ContextVar
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

from pydantic import AfterValidator, Discriminator, Field, Tag

from snowmpm.errors import nearest_file
from snowmpm.scenes.spec import Number, refuse

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


def _check_file(value):
    if not value or "\0" in value:
        raise refuse("must be the name of a file")
    base_dir = _surroundings.get().base_dir
    if base_dir is not None and not (path := base_dir / Path(value).expanduser()).is_file():
        raise refuse(f"no such file (looked for {path}, from the scene's folder){nearest_file(path)}")
    return value


def zero_vector():
    """As many zeros as the scene has axes."""
    return (0.0,) * (dimension() or 3)


Vector = Annotated[tuple[Number, ...], Field(min_length=2, max_length=3), AfterValidator(_check_vector)]
Direction = Annotated[Vector, AfterValidator(_check_direction)]
Pair = tuple[Number, Number]
Interval = Annotated[Pair, AfterValidator(_check_interval)]
FileName = Annotated[str, Field(strict=True), AfterValidator(_check_file)]


def by_type(**branches: Any):
    """A union whose member is selected by the TOML type of the value, so that messages concern one member only.

    branches: `number`, `text`, `list`, `table`, each with its type. A value of any other type is validated as the
    first.
    """
    first = next(iter(branches))

    def branch(value):
        kinds = {
            "table": isinstance(value, dict) or hasattr(value, "model_fields"),
            "list": isinstance(value, list | tuple),
            "text": isinstance(value, str),
            "number": isinstance(value, int | float),
        }
        return tag(next((name for name in branches if kinds[name]), first))

    union = None
    for name, member in branches.items():
        tagged = Annotated[member, Tag(tag(name))]
        union = tagged if union is None else union | tagged
    return Annotated[union, Discriminator(branch)]


def tag(name):
    """Mark of a union member in an error's location; no key of a scene can equal it."""
    return f"<{name}>"
