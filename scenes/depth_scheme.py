"""Which of the two depth-averaged schemes computes a scene, where the scene leaves it open."""

from typing import Any

from snowmpm import components

OF_COLUMNS = ("damping", "mixing", "rim")
"""Keys of [solver.depth] that act on columns alone."""


def for_columns(scene: Any, last: bool = True) -> list[tuple[str, Any, str]]:
    """(key, value, why) of all in a depth-averaged scene that needs columns; last: whether no method takes over."""
    usual = type(scene.solver.depth)()
    found = [(f"solver.depth.{name}", scene.solver.depth[name], "acts on columns") for name in OF_COLUMNS
             if scene.solver.depth[name] != usual[name]]
    names = {body.material for body in scene.bodies}
    if len(names) > 1:
        found.append(("materials", ", ".join(sorted(names)), "are several, and a cell holds snow of one"))
    for component in components.used(scene):
        if component.supports(scene.solver.method) and not component.supports("volumes"):
            found.append((*next(iter(component.asked(scene))), "acts on columns"))
    found += [(f"events.{i}.kind", event.kind, "needs to know the body that snow is of")
              for i, event in enumerate(scene.events) if event.NEEDS == "removal"]
    if scene.zone:
        found.append(("zone.region", "a table", "takes columns in, and gives them back"))
    if not last:
        found.append(("switch", "a table", "hands columns over"))
    return found
