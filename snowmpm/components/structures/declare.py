"""Structures: their tables, and what they do not go with."""

from typing import Annotated

from pydantic import Field

from snowmpm.components.contract import Component
from snowmpm.components.structures.framework_tables import Framework
from snowmpm.components.structures.tables import AnyKind, Structure
from snowmpm.errors import InputError
from snowmpm.registry import COMPONENTS
from snowmpm.scenes.spec import Spec

STRONG = ("mpm",)
"""Methods whose adapter lets structures answer within the step."""


class OfScene(Spec):
    """Keys of a scene."""

    structures: Annotated[tuple[Annotated[Structure | Framework, AnyKind()], ...], Field(max_length=16)] = ()
    """masts, posts and walls that bend, frameworks of members, and what another program computes"""


def asked(scene):
    """(key, value) of each."""
    for i, structure in enumerate(scene.structures):
        yield f"structures.{i}.name", structure.name


def refuse(scene):
    """Raise InputError for names that another thing has, and for an answer that the method cannot wait for."""
    # Their segments are obstacles
    seen = {obstacle.name.rstrip("0123456789").rstrip("_") for obstacle in scene.obstacles}
    for i, structure in enumerate(scene.structures):
        key, name = f"structures.{i}.name", structure.name
        if name in seen:
            raise InputError.at(key, name, "there is another of this name among the structures", scene.source)
        seen.add(name)
        if isinstance(structure, Framework):  # its numbers and segments have names of its own
            for other in (*scene.obstacles, *scene.structures):
                if other.name.startswith(f"{name}_"):
                    raise InputError.at(key, name, f"must not be how the name of another begins: {other.name}",
                                        scene.source)
        if structure.coupling == "strong" and scene.solver.method not in STRONG:
            needed = f'needs solver.method = "{STRONG[0]}" in place of "{scene.solver.method}"'
            raise InputError.at(f"structures.{i}.coupling", "strong", needed, scene.source)


COMPONENTS.add(Component(
    "structures", __package__, "structures", asked, order=85, keys={"scene": OfScene},
    owns=("the contact of surfaces",),
    beside=("switch", "periodic sides of the domain", 'water.scheme = "v_w"'), refuse=refuse, in_python=True,
    obstacles=f"{__package__}.from_scene:standing", cautions=f"{__package__}.cautions", atlas=f"{__package__}.atlas"))
