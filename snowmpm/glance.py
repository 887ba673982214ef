"""How objects show themselves at a prompt and in a notebook: a title and a few facts, never a table of numbers."""

import html
import textwrap
from typing import Any

WIDTH = 100
"""Characters of a line."""


class Glance:
    """Base of classes with a short `repr`, of a dozen lines: they give a `_glance()` -> (title, {name: text})."""

    def _glance(self) -> tuple[str, dict[str, Any]]:
        raise NotImplementedError

    def __repr__(self) -> str:
        title, facts = self._glance()
        width = max(map(len, facts), default=0)
        lines = [title]
        for name, value in facts.items():
            lines += textwrap.wrap(str(value), WIDTH, initial_indent=f"  {name:<{width}}  ", max_lines=2,
                                   subsequent_indent=" " * (width + 4), placeholder=" ...")
        return "\n".join(lines)

    def _repr_html_(self) -> str:
        title, facts = self._glance()
        cells = [(html.escape(name), html.escape(textwrap.shorten(str(value), 2 * WIDTH, placeholder=" ...")))
                 for name, value in facts.items()]
        rows = "".join(f"<tr><td>{name}</td><td style='text-align:left'>{value}</td></tr>" for name, value in cells)
        return f"<b>{html.escape(title)}</b><table>{rows}</table>"


class ArraysGlance(Glance):
    """The same for a data class of arrays, tables of them and numbers: their shapes, types and ranges."""

    def _glance(self) -> tuple[str, dict[str, Any]]:
        return type(self).__name__, {name: told(value) for name, value in vars(self).items()
                                     if not name.startswith("_")}


def told(value: object) -> str:
    """An array by shape, type and range, a table by its entries, anything else as it is, cut short."""
    import numpy as np  # not for who counts only

    if isinstance(value, np.ndarray):
        if value.size <= 3:
            return " ".join(str(value).split())
        kind = f"{value.shape} {value.dtype}"
        finite = value[np.isfinite(value)] if value.dtype.kind in "fiu" else value[:0]
        return kind if not finite.size else f"{kind}, {finite.min():.6g} to {finite.max():.6g}"
    if isinstance(value, dict):
        return ", ".join(f"{name} {getattr(item, 'shape', '')}".rstrip() for name, item in value.items())
    return textwrap.shorten(str(value), WIDTH, placeholder=" ...")


def counted(number: int) -> str:
    """1234567 -> 1 234 567."""
    return f"{number:,}".replace(",", " ")
