"""The public Python names, with their docstrings.

Docstrings hold equations and lists that are laid out by hand, so they are shown as they stand.
"""

import inspect
import pydoc
import re

from snowmpm.cli.reference.markdown import plain

INTRODUCTION = """# Python interface

Every public name. [From Python](python.md) shows how they are used, and says what may change from version to version.
Names that are not here are internal and may change at any time.
"""

PUBLIC = {
    "Runs": ("snowmpm", ("run", "load_scene", "open_run", "register", "start", "campaign")),
    "A simulation, step by step": ("snowmpm", ("Simulation",)),
    "A run that was written": ("snowmpm.io", ("Run", "Frame", "Map", "Terrain", "Obstacle")),
    "Scenes and cards": ("snowmpm.scenes", ("Scene", "library", "material_card", "material_cards", "friction_card",
                                            "friction_cards")),
    "A material at a point": ("snowmpm.materials", ("MaterialPoint", "Law")),
    "Export": ("snowmpm.render.export", ("export_run",)),
    "What plugins derive from": ("snowmpm", ("ground.FrictionLaw", "scenes.events.Event", "scenes.forces.Force",
                                             "scenes.shapes.Shape", "scenes.shapes.Solid",
                                             "components.contract.Component", "stepping.component.Adapter",
                                             "particles.fields.ParticleField", "methods.MethodEntry",
                                             "cli.command.Command")),
}
"""Public names by chapter: (module, names). Laws and functions that draw follow."""

OF_PYDANTIC = "pydantic"


def page():
    """All public names as Markdown."""
    lines = [INTRODUCTION]
    for title, (module, names) in chapters().items():
        lines += [f"## {title}", ""]
        for name in names:
            lines += _entry(f"{module}.{name}", pydoc.locate(f"{module}.{name}"))
    return "\n".join(lines)


def chapters():
    """{title: (module, names)} of all public names."""
    import snowmpm.render
    from snowmpm.materials import LAWS

    laws = sorted(law.__name__ for law in LAWS.values() if law.__module__.startswith("snowmpm.materials"))
    drawing = [name for name in snowmpm.render.__all__ if name.startswith("render_")]
    return {**PUBLIC, "Laws": ("snowmpm.materials", laws), "Pictures": ("snowmpm.render", drawing)}


def _entry(path, shown):
    yield from (f"### `{path}`", "")
    data = inspect.isclass(shown) and any(base.__module__.startswith(OF_PYDANTIC) for base in shown.__mro__)
    if not data:
        yield from _signature(path.rsplit(".", 1)[-1], shown)
    yield from _docstring(shown)
    if inspect.isclass(shown):
        yield from _members(shown)


def _members(shown):
    """Public methods and properties of a class, those of its own package."""
    for one in inspect.classify_class_attrs(shown):
        own = one.defining_class.__module__.startswith("snowmpm") and one.name[0] != "_"
        if not own or one.kind == "data" or not inspect.getdoc(one.object):
            continue
        yield from (f"#### `{one.name}`", "")
        if one.kind == "method":
            yield from _signature(one.name, one.object)
        yield from _docstring(one.object)


def _signature(name, shown):
    try:
        signature = inspect.signature(shown)
    except (TypeError, ValueError):
        return
    parts = [_without_objects(str(one)) for one in signature.parameters.values() if one.name != "self"]
    returned = signature.return_annotation
    end = "" if returned is inspect.Signature.empty else f" -> {_without_objects(inspect.formatannotation(returned))}"
    text = f"{name}({', '.join(parts)}){end}"
    if len(text) > 100:
        text = f"{name}(\n    " + ",\n    ".join(parts) + f"\n){end}"
    yield from ("```python", re.sub(r"(: |-> )'([^']*)'", r"\1\2", text), "```", "")


def _without_objects(annotation):
    """An annotation without checks and defaults that have no name: Annotated[X, <object>] is X, = <object> is = ..."""
    named = re.sub(r"typing\.Annotated\[([^\[\]]*), <[^>]*>\]", r"\1", annotation)
    return re.sub(r"= <.*>$", "= ...", named)


def _docstring(shown):
    summary, _, rest = (inspect.getdoc(shown) or "").partition("\n\n")
    yield from (plain(summary), "")
    if rest:
        yield from ("```text", rest.rstrip(), "```", "")
