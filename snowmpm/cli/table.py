"""Facts by name, printed as a table that also reads well in a pipe."""

from snowmpm.cli.wording import count, duration, memory

FORMATS = {"memory": memory, "run_time": duration, "wall_time": duration}
UNITS = {"dt": "s", "end_time": "s", "mass": "kg", "bytes_per_particle": "B"}


def print_facts(title, values):
    """A title and one line a fact; facts within a fact are indented."""
    print(title)
    for line in _lines(values, "  "):
        print(line)


def _lines(values, indent, inner=False):
    width = max((len(str(name)) for name in values), default=0)
    for name, value in values.items():
        # Names of facts are words; names inside a fact are a scene's own.
        label = f"{indent}{name if inner else name.replace('_', ' '):<{width}}"
        if isinstance(value, dict):
            yield label.rstrip()
            yield from _lines(value, indent + "  ", inner=True)
        else:
            unit = f" {UNITS[name]}" if name in UNITS else ""
            yield f"{label}  {_text(name, value)}{unit}"


def _text(name, value):
    if name in FORMATS and isinstance(value, int | float):
        return FORMATS[name](value)
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, int):
        return count(value)
    if isinstance(value, float):
        # Entries of lists are coordinates, large where they come from a map.
        return f"{value:.4g}" if name else f"{round(value, 3):.10g}"
    if isinstance(value, list | tuple):
        items = ", ".join(_text(None, item) for item in value) or "none"
        return f"[{items}]" if name is None else items
    return str(value)
