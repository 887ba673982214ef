"""Optional pieces of physics, one folder each: what a scene does without, the program does without.

`NAME/declare.py` says what a component is, without the compiler of kernels: the tables of a scene that ask for it, what
it does not go with, its rules of `check` and its entries of the atlas. `NAME/METHOD.py` is its adapter for a method,
`adapter(model, solver) -> stepping.component.Adapter`. A method supports the components that have an adapter for it.
Without a folder and its line in NAMES all else works as before (`tests/components/test_deletion.py`).
"""

import importlib

from snowmpm.registry import COMPONENTS

NAMES = (
    "face_loads",
)


def declared():
    """All `contract.Component`s, in the order in which they act."""
    for name in NAMES:
        importlib.import_module(f"{__name__}.{name}.declare")
    return sorted(COMPONENTS.values(), key=lambda component: component.order)


def used(scene):
    """Those that a scene asks for."""
    return [component for component in declared() if any(True for _ in component.asked(scene))]


def act(model, solver):
    """Let the components of a model's scene act on its solver from now on."""
    method = model.scene.solver.method
    for component in used(model.scene):
        solver.adapters.add(component.adapter(method)(model, solver))
