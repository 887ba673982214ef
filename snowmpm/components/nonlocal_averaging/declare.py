"""Laws whose loss of strength is averaged over a length: who asks for it, and what it does not go with."""

from snowmpm.components.contract import Component
from snowmpm.registry import COMPONENTS

KEY = "nonlocal_length"
"""Of a law: l [m]."""


def averaged(scene):
    """{material: length [m]} of a scene's laws that ask for it."""
    return {name: law.of_components[KEY] for name, law in scene.materials.items() if KEY in law.of_components}


def asked(scene):
    """(key, value) of each."""
    for name, length in averaged(scene).items():
        yield f"materials.{name}.{KEY}", length


COMPONENTS.add(Component(
    "nonlocal_averaging", __package__, "averages over a length", asked, order=60, rests=True,
    beside=('initial.relaxation = "static"',), cautions=f"{__package__}.cautions",
    atlas=f"{__package__}.atlas"))
