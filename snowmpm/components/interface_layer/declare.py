"""Layers thinner than a cell, carried by points: their keys, and what they do not go with."""

from typing import Annotated

from pydantic import Field

from snowmpm.components.contract import Component
from snowmpm.errors import InputError
from snowmpm.registry import COMPONENTS
from snowmpm.scenes.spec import Spec
from snowmpm.schemes import TRANSFERS

PointsPerCell = Annotated[int, Field(strict=True, ge=1, le=64)]


class OfBody(Spec):
    """Keys of a body."""

    interface: PointsPerCell | None = None
    """of a layer on the ground: carry it by this many points a cell and direction, without cells of its own
    (`snowmpm docs interface`); filled with particles when missing"""


class OfWeakLayer(Spec):
    """Keys of the weak layer of a saw test."""

    interface: PointsPerCell | None = None
    """carry the layer by this many points a cell and direction, without cells of its own (`snowmpm docs interface`)"""


def key_of(scene, i):
    """The key that makes body i one."""
    return "saw_test.weak_layer.interface" if scene.saw_test else f"bodies.{i}.interface"


def asked(scene):
    """(key, value) of each body that is one."""
    for i, body in enumerate(scene.bodies):
        if body.interface:
            yield key_of(scene, i), body.interface


def thickness_of(scene, body):
    """Thickness [m] of a body that is one."""
    return scene.saw_test.weak_layer.thickness if scene.saw_test else body.shape.top


def carries(scene, body):
    """Whether it carries a body, which then has no cells of its own."""
    return body.interface is not None


def law(scene, name):
    """The law of a material as that of the layer that is made of it, else None."""
    layer = next((body for body in scene.bodies if body.interface and body.material == name), None)
    return layer and scene.materials[name].of_whole_layer(thickness_of(scene, layer))


def refuse(scene):
    """Raise InputError for a layer that cannot be one."""
    for i, body in enumerate(scene.bodies):
        if body.interface:
            _refuse_body(scene, key_of(scene, i), body)
    solver, (key, points) = scene.solver, next(asked(scene))
    if not TRANSFERS[solver.transfer].flip:
        allowed = " or ".join(f'"{name}"' for name, transfer in TRANSFERS.items() if transfer.flip)
        raise InputError.at(key, points, f'needs solver.transfer = {allowed} in place of "{solver.transfer}"',
                            scene.source)


def _refuse_body(scene, key, body):
    shape, test = body.shape, scene.saw_test
    if test and test.base is not None:
        raise InputError.at(key, body.interface, "needs rigid ground below: leave saw_test.base out", scene.source)
    if test and test.weak_layer.cells is not None:
        raise InputError.at(key, body.interface, "does not go with cells, of which such a layer has none", scene.source)
    if not test and (shape.kind != "layer" or shape.bottom > 0.0 or not isinstance(shape.top, int | float)):
        raise InputError.at(key, body.interface, "needs a shape of kind \"layer\" with bottom = 0 and top a number",
                            scene.source)
    for computed in scene.materials[body.material].of_components:
        raise InputError.at(key, body.interface, f"does not go with materials.{body.material}.{computed}", scene.source)
    for other in scene.bodies:
        alike = other.interface and thickness_of(scene, other) == thickness_of(scene, body)
        if other.material == body.material and not alike:
            raise InputError.at(key, body.interface, f"needs a material that bodies of another kind or thickness do not"
                                f" have, as {other.name} does", scene.source)


COMPONENTS.add(Component(
    "interface_layer", __package__, "layers thinner than a cell", asked, order=20, rests=True,
    keys={"bodies": OfBody, "saw_test.weak_layer": OfWeakLayer},
    owns=("the deformation of particles", "the spare number of a node", "the velocity fields of nodes"),
    beside=("switch", "zone", "water", "initial.from", 'initial.relaxation = "static"', "solver.kernel"),
    refuse=refuse, carries=carries, law=law, seeds=f"{__package__}.points:seeds",
    saw=f"{__package__}.saw_test:PointedLayer", cautions=f"{__package__}.cautions", atlas=f"{__package__}.atlas"))
