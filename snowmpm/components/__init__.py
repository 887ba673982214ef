"""Optional pieces of physics, one folder each: what a scene does without, the program does without.

`NAME/declare.py` says what a component is, without the compiler of kernels: the tables of a scene that ask for it, what
it does not go with, its rules of `check` and its entries of the atlas. `NAME/METHOD.py` is its adapter for a method,
`adapter(model) -> stepping.component.Adapter`. A method supports the components that have an adapter for it.
Without a folder and its line in NAMES all else works as before (`tests/components/test_deletion.py`).
"""

import importlib
from typing import Any

import numpy as np

from snowmpm.errors import InputError
from snowmpm.registry import COMPONENTS, resolved

NAMES = {
    "body_contact": (),
    "entrainment": (),
    "erodible_snow": (),
    "f_bar": (),
    "face_loads": (),
    "flow_water": (),
    "forcing_and_damping": (),
    "forest_and_deposition": (),
    "interface_layer": (),
    "nonlocal_averaging": (),
    "pore_water": (),
    "powder_layer": (),
    "precice": ("structures",),
    "pressure_panels": (),
    "rigid_bodies": (),
    "seepage": (),
    "structures": (),
    "two_velocities": (),
}
"""Each with the components that it builds on."""


def declared():
    """All `contract.Component`s, in the order in which they act."""
    for name, needed in NAMES.items():
        if NAMES.keys() >= set(needed):
            importlib.import_module(f"{__name__}.{name}.declare")
    return sorted(COMPONENTS.values(), key=lambda component: component.order)


def used(scene):
    """Those that a scene asks for."""
    return [component for component in declared() if any(True for _ in component.asked(scene))]


def adapters(model, method):
    """An adapter for a method of each that a model's scene asks for and the method supports, in the order in which they
    act."""
    return [component.adapter(method)(model) for component in used(model.scene) if component.supports(method)]


def builder(scene, method):
    """What builds the solver of a scene in place of that of its method, None without."""
    return next((component.builders[method] for component in used(scene) if method in component.builders), None)


def filled(scene, body, population):
    """`Population` of the particles of a body with those that components add."""
    for component in used(scene):
        if component.fills:
            population = resolved(component.fills)(scene, body, population)
    return population


def more_laws(model):
    """Laws of the particles that components add to a model."""
    return [law for component in used(model.scene) if component.laws for law in resolved(component.laws)(model)]


def symptoms(scene):
    """What tells why a run of a scene failed (`contract.Component.symptom`)."""
    return [resolved(component.symptom) for component in used(scene) if component.symptom]


def carried(scene, body):
    """Whether one of them carries a body of a scene, which then has no cells of its own."""
    return any(component.carries(scene, body) for component in used(scene))


def lies(scene, body):
    """Whether a body of a scene is no part of the flow at the start, as snow cover is not."""
    return any(component.lies(scene, body) for component in used(scene))


def velocity_fields(scene):
    """Number of the velocity field of each body of a scene (n,): 0 for all without a component that parts them."""
    makers = (component.fields for component in used(scene) if component.fields)
    return next((make(scene) for make in makers), np.zeros(len(scene.bodies), int))


def motion_of(scene, i):
    """What makes the motion of obstacle i of a scene, `SolidShape` -> motion; None where no component does."""
    for component in used(scene):
        if component.motion:
            make = resolved(component.motion)
            return lambda shape: make(scene, i, shape)
    return None


def standing(scene):
    """{component: what it makes of a scene}, and the `Obstacle`s of all."""
    made, obstacles = {}, []
    for component in used(scene):
        if component.obstacles:
            made[component.name], own = resolved(component.obstacles)(scene)
            obstacles += own
    return made, obstacles


def stepping(simulation):
    """What computes the steps of a simulation in its place; None: it does itself."""
    found = (component.steps for component in used(simulation.scene) if component.steps)
    return next((resolved(make)(simulation) for make in found), None)


def accelerating():
    """The component that takes accelerations of functions (`Component.accelerates`). Raises InputError without one."""
    found = next((component for component in declared() if component.accelerates), None)
    if found is None:
        raise InputError("add_acceleration: no component takes accelerations of functions")
    return found


def refuse_resume(scene):
    """Raise InputError for a run of a scene that cannot be resumed."""
    for component in used(scene):
        if component.refuse_resume:
            component.refuse_resume(scene)


def law_of(scene, material):
    """The law of a component for a material of a scene, None without one."""
    return next((law for component in used(scene) if (law := component.law(scene, material)) is not None), None)


def seeds(scene, i, surface, material):
    """`Population` of a component for body i of a scene on its ground, of the material of this index; None without
    one."""
    makers = (resolved(component.seeds) for component in used(scene) if component.seeds)
    return next((found for make in makers if (found := make(scene, i, surface, material)) is not None), None)


_tables: dict[str, tuple[Any, ...]] = {}


def open_table(name, *tables):
    """Let components add keys to a table of a scene (`contract.Component.keys`), by its place, "solver", or to all
    kinds of tables that may stand there."""
    _tables[name] = tables
    for component in declared():
        extend(component, name)


def extend(component, *names):
    """Give tables of a scene, all by default, the keys that a component adds; -> those that have changed. Raises
    InputError for a place where no component may add keys."""
    changed = set()
    if not names and (unknown := [name for name in component.keys if name not in _tables]):
        raise InputError(f"component {component.name}: keys at {unknown[0]!r}: must be at {', '.join(_tables)}")
    for name, keys in component.keys.items():
        if name in (names or component.keys):
            for table in _tables[name]:
                table.model_fields.update(keys.model_fields)
                table.EXTENDED = (*table.EXTENDED, keys)
                if table.__pydantic_complete__:
                    table.model_rebuild(force=True)
                changed.add(table)
    return changed


# Scenes open their tables to components, whoever is imported first
importlib.import_module("snowmpm.scenes.schema")
