"""Structures of another program: what asks for them, and what they do not go with."""

from snowmpm.components.contract import Component
from snowmpm.components.precice.tables import External
from snowmpm.errors import InputError
from snowmpm.registry import COMPONENTS


def asked(scene):
    """(key, value) of each."""
    for i, structure in enumerate(scene.structures):
        if isinstance(structure, External):
            yield f"structures.{i}.precice.file", structure.precice.file


def refuse(scene):
    """Raise InputError for a configuration of preCICE that does not fit the scene."""
    from snowmpm.components.precice.from_scene import windows  # it needs the compiler, a scene does not

    windows(scene)


def refuse_resume(scene):
    """Raise InputError for a run that another program took part in: preCICE keeps no state."""
    for key, file in asked(scene):
        raise InputError.at(key, file, "is not resumed: neither preCICE nor the other program is where the checkpoint"
                                       " is; start both anew, with --overwrite", scene.source)


COMPONENTS.add(Component(
    "precice", __package__, "structures of another program", asked, order=86, refuse=refuse, moves_on=True,
    steps=f"{__package__}.windows:steps", refuse_resume=refuse_resume, cautions=f"{__package__}.cautions"))
