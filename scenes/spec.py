"""Building blocks of a scene: frozen tables that refuse unknown keys, and numbers with bounds."""

import reprlib
from collections.abc import Callable, Iterable, Mapping
from typing import Annotated, Any, ClassVar

from pydantic import AfterValidator, BaseModel, Field, GetPydanticSchema, model_validator
from pydantic_core import PydanticCustomError, PydanticKnownError, core_schema

from snowmpm.keys import TABLE_CONFIG, Keyed


class Spec(Keyed, BaseModel):
    """A table of a scene file: immutable, without unknown keys; messages show the docstring of a field."""

    model_config = TABLE_CONFIG

    REMOVED: ClassVar[Mapping[str, tuple[object, str]]] = {}
    """Keys of earlier versions: {key: (value that changed nothing, as resolved scenes have it; what to do instead)}."""

    @model_validator(mode="before")
    @classmethod
    def _without_removed(cls, given: Any) -> Any:
        found = cls.REMOVED.keys() & given.keys() if isinstance(given, dict) else ()
        for key in found:
            nothing, instead = cls.REMOVED[key]
            if given[key] != nothing:
                raise refuse(instead, key, given[key])
        return {key: value for key, value in given.items() if key not in found} if found else given

    def __repr_args__(self):
        """The given values without defaults; long lists are shortened."""
        return [(name, _Cut(self[name])) for name in type(self).model_fields if name in self.model_fields_set]


class _Cut:
    """A value as `repr` shows it, cut short."""

    def __init__(self, value):
        self._value = value

    def __repr__(self):
        cut = reprlib.Repr()
        cut.maxother = cut.maxstring = LONGEST
        return cut.repr(self._value)


LONGEST = 300
"""Largest number of characters of a nested value in `repr`."""


SIZES = (1e-12, 1e12)
"""Allowed magnitudes of nonzero numbers in a scene: no quantity of snow in SI units lies outside, and derived numbers
still fit a float32 or a grid."""


def _check_size(value):
    if value and not SIZES[0] <= abs(value) <= SIZES[1]:
        raise refuse(f"out of reach: sizes of numbers are from {SIZES[0]:g} to {SIZES[1]:g}")
    return value


# Strict: "0.1" and true are not numbers, and TOML's nan and inf are refused.
Number = Annotated[float, Field(strict=True, allow_inf_nan=False), AfterValidator(_check_size)]
Positive = Annotated[Number, Field(gt=0.0)]
NonNegative = Annotated[Number, Field(ge=0.0)]
Fraction = Annotated[Number, Field(ge=0.0, le=1.0)]
Name = Annotated[str, Field(strict=True, pattern=r"^[A-Za-z0-9][A-Za-z0-9_.\-]*$", max_length=100)]


def one_of(names: Callable[[], Iterable[str]]) -> GetPydanticSchema:
    """Type of a key that names an entry of a registry. names: `names()` -> registered names, called whenever a scene
    is read, so that later entries are included; messages are those of a Literal."""

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

    allowed: text of what is allowed. key, value: the place, if it is not the table or value under validation itself;
    `key` is then relative to that table.
    """
    return PydanticCustomError("scene_check", "{allowed}", {"allowed": allowed, "key": key, "value": value})


def check_period(start, stop):
    """Raise an error unless `stop` [s], None for never, is after `start`."""
    if stop is not None and stop <= start:
        raise refuse(f"must be after start = {start:g}", "stop", stop)
