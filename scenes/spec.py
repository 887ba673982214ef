"""What every part of a scene is made of: frozen tables that refuse unknown keys, and numbers with their bounds."""

import reprlib
from collections.abc import Callable, Iterable
from typing import Annotated, Any

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, GetPydanticSchema
from pydantic_core import PydanticCustomError, PydanticKnownError, core_schema


class Spec(BaseModel):
    """A table of a scene file: nothing settable, no unknown key; messages show the docstring under a field."""

    model_config = ConfigDict(frozen=True, extra="forbid", use_attribute_docstrings=True)

    def __repr_args__(self):
        """What was given, not the defaults; long lists are cut."""
        return [(name, _Cut(getattr(self, name))) for name in type(self).model_fields if name in self.model_fields_set]


class _Cut:
    """A value as `repr` shows it, cut short."""

    def __init__(self, value):
        self._value = value

    def __repr__(self):
        cut = reprlib.Repr()
        cut.maxother = cut.maxstring = LONGEST
        return cut.repr(self._value)


LONGEST = 300
"""Characters of a value within another that `repr` shows."""


SIZES = (1e-12, 1e12)
"""What the numbers of a scene may be in size, beside 0: nothing of snow, in SI units, is smaller or larger, and what is
made of them still fits a float32 or a grid."""


def _check_size(value):
    if value and not SIZES[0] <= abs(value) <= SIZES[1]:
        raise refuse(f"out of reach: sizes of numbers are from {SIZES[0]:g} to {SIZES[1]:g}")
    return value


# Strict: "0.1" and true are not numbers; TOML's nan and inf are none either.
Number = Annotated[float, Field(strict=True, allow_inf_nan=False), AfterValidator(_check_size)]
Positive = Annotated[Number, Field(gt=0.0)]
NonNegative = Annotated[Number, Field(ge=0.0)]
Fraction = Annotated[Number, Field(ge=0.0, le=1.0)]
Name = Annotated[str, Field(strict=True, pattern=r"^[A-Za-z0-9][A-Za-z0-9_.\-]*$", max_length=100)]


def one_of(names: Callable[[], Iterable[str]]) -> GetPydanticSchema:
    """What makes a `str` the name of an entry of a registry: `Annotated[str, one_of(names)]`. names: `names()` -> what
    there is, asked whenever a scene is read, so that what is registered later is known; messages are those of a
    Literal."""

    def check(value: Any) -> str:
        known = list(names())
        if not isinstance(value, str) or value not in known:
            quoted = [repr(name) for name in known]
            listed = " or ".join([part for part in (", ".join(quoted[:-1]), quoted[-1]) if part])
            raise PydanticKnownError("literal_error", {"expected": listed})
        return value

    def schema(source: Any, handler: Any) -> core_schema.CoreSchema:
        return core_schema.no_info_plain_validator_function(
            check, serialization=core_schema.to_string_ser_schema())

    def json_schema(core: Any, handler: Any) -> dict[str, Any]:
        return {"enum": list(names()), "type": "string"}

    return GetPydanticSchema(schema, json_schema)


def refuse(allowed, key=None, value=None):
    """The error of a check that the types cannot express.

    allowed: what would have been right. key, value: where, when it is not the table or value under validation itself;
    `key` is then relative to that table.
    """
    return PydanticCustomError("scene_check", "{allowed}", {"allowed": allowed, "key": key, "value": value})
