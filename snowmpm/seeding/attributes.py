"""The thickness of snow among the attributes of a vector file."""

import math
from collections.abc import Iterable
from typing import Any

USUAL = ("thickness", "d0")
"""Attributes that hold the thickness, the first that a file has; `d0` is what AvaFrame called it at first."""

ABSENT = "has no attribute"
"""How it is said of a file that has none of these, in place of a wrong value."""

THICKEST = 100.0
"""[m]: what is more is no thickness in metres, but centimetres or a number for "none"."""


def chosen(names: Iterable[str], wanted: str | None) -> str | None:
    """The attribute of a file that holds the thickness, whatever its case: `wanted`, or the first of USUAL. None: there
    is none."""
    known = list(names)
    by_lower = {name.lower(): name for name in reversed(known)} | {name: name for name in known}
    asked = (wanted,) if wanted else USUAL
    return next((by_lower[one] for name in asked for one in (name, name.lower()) if one in by_lower), None)


def thickness_of(value: Any) -> tuple[float | None, str]:
    """Thickness [m] of a value as a file has it, and ""; or None, and what is wrong with the value."""
    if isinstance(value, bytes):
        value = value.decode("utf-8", "replace")
    text = value.strip() if isinstance(value, str) else value
    if text is None or text == "" or (isinstance(text, float) and math.isnan(text)):
        return None, "is missing"
    shown = repr(text) if isinstance(text, str) else f"{text}"
    if isinstance(text, bool | list | dict):
        return None, f"= {shown[:40]}: must be a number of metres"
    try:
        if isinstance(text, str) and "_" in text:  # which Python takes for a mark between digits
            raise ValueError
        number = float(text)
    except (TypeError, ValueError, OverflowError):
        comma = isinstance(text, str) and text.count(",") == 1 and _is_number(text.replace(",", "."))
        hint = f"; with a point: {text.replace(',', '.')}" if comma else ""
        return None, f"= {shown[:40]}: must be a number of metres{hint}"
    if not 0.0 < number <= THICKEST:
        return None, f"= {number:.6g}: must be above 0 and at most {THICKEST:g} m"
    return number, ""


def _is_number(text: str) -> bool:
    try:
        return math.isfinite(float(text))
    except ValueError:
        return False
