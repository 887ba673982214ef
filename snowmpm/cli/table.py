"""Facts by name, printed as a table that also reads well in a pipe, or as JSON."""

import json
import math
import shutil
import sys
import textwrap

from snowmpm.cli.wording import count, duration, memory
from snowmpm.errors import shown_line
from snowmpm.quantities.quantity import per_width

FORMATS = {"memory": memory, "run_file": memory, "checkpoint": memory,
           "run_time": duration, "wall_time": duration, "processor_time": duration, "size": memory}
UNITS = {"dt": "s", "end_time": "s", "mass": "kg", "bytes_per_particle": "B"}
MOST_ITEMS = 200  # of a list
LONGEST = 100  # characters of a line; wider text is harder to read


def print_facts(title, values):
    """Print a title and one line a fact; nested facts are indented. On a terminal titles are bold, names faint."""
    styled = sys.stdout.isatty()
    lead = "\n" if title.startswith("\n") else ""
    print(lead + _styled(shown_line(title.lstrip("\n")), "1", styled))
    for line in _lines(values, "  ", line_length(), styled):
        print(line)


def line_length():
    """Characters of a line of text: width of the terminal, at most `LONGEST`."""
    return min(shutil.get_terminal_size((LONGEST, 24)).columns, LONGEST)


def print_definitions(groups):
    """Print `snowmpm.quantities.Quantity`s with their definitions. groups: {title: quantities}."""
    for title, group in groups.items():
        print(f"\n{title}")
        for one in group:
            print(f"  {one.name}: {one.label}{'' if one.unit == '1' else f' [{one.unit}]'}")
            print(textwrap.fill(one.definition, line_length(), initial_indent="      ", subsequent_indent="      ",
                                break_on_hyphens=False))


def print_json(values):
    """Print one JSON object; nan and infinity, which JSON lacks, become null."""
    print(json.dumps(_plain(values), indent=1, ensure_ascii=False))


def _plain(value):
    if isinstance(value, dict):
        return {str(name): _plain(item) for name, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if hasattr(value, "tolist"):  # NumPy
        return _plain(value.tolist())
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value if isinstance(value, str | int | float | None) else str(value)


def _styled(text, code, styled):
    return f"\033[{code}m{text}\033[0m" if styled and text else text


def _lines(values, indent, width, styled, inner=False):
    names = max((len(str(name)) for name in values), default=0)
    per = per_width if values.get("dimension") == 2 else str
    for name, value in values.items():
        # Names of facts are words; names inside a fact are a scene's own.
        shown = shown_line(name if inner else name.replace("_", " "), LONGEST)
        label = f"{indent}{shown:<{min(names, LONGEST)}}"
        if isinstance(value, dict):
            yield _styled(label.rstrip(), "2", styled)
            yield from _lines(value, indent + "  ", width, styled, inner=True)
        else:
            unit = f" {per(UNITS[name])}" if name in UNITS else ""
            text = f"{_text(name, value)}{unit}"
            room = max(width - len(label) - 2, 30)
            rows = _wrapped(text, room) if isinstance(value, list | tuple) else [text]
            yield f"{_styled(label, '2', styled)}  {rows[0]}"
            yield from (f"{' ' * len(label)}  {row}" for row in rows[1:])


def _wrapped(text, room):
    """Rows of a list, broken between its entries only."""
    glued = text.replace(" ", "\0").replace(",\0", ", ")
    rows = textwrap.wrap(glued, room, break_long_words=False, break_on_hyphens=False)
    return [row.replace("\0", " ") for row in rows] or [""]


def _plain_digits(value):
    """Four significant digits; a large number in full rather than with a power of ten."""
    text = f"{value:.4g}"
    return count(round(value)) if "e+" in text and abs(value) < 1e15 else text


def _text(name, value):
    if name in FORMATS and isinstance(value, int | float):
        return FORMATS[name](value)
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, int):
        return count(value)
    if isinstance(value, float):
        # Entries of lists are coordinates, large where they come from a map.
        return _plain_digits(value) if name else f"{round(value, 3):.10g}"
    if isinstance(value, list | tuple):
        shown = [_text(None, item) for item in value[:MOST_ITEMS]]
        items = ", ".join(shown + [f"... {count(len(value))} in all"] * (len(value) > MOST_ITEMS)) or "none"
        return f"[{items}]" if name is None else items
    return shown_line(value)
