"""Refusal of scenes whose interfaces cannot be."""

from snowmpm.errors import InputError
from snowmpm.schemes import TRANSFERS
from snowmpm.setup.interface_points import thickness_of


def refuse_interfaces(scene):
    """Raise InputError for a layer that cannot be an interface (`particles.interface`), or beside what does not know
    one."""
    for i, body in enumerate(scene.bodies):
        if body.interface:
            key = "saw_test.weak_layer.interface" if scene.saw_test else f"bodies.{i}.interface"
            _refuse_body(scene, i, key, body)
            _refuse_beside(scene, key, body.interface)


def _refuse_body(scene, i, key, body):
    shape = body.shape
    if not scene.saw_test and (shape.kind != "layer" or shape.bottom > 0.0 or not isinstance(shape.top, int | float)):
        raise InputError.at(key, body.interface, "needs a shape of kind \"layer\" with bottom = 0 and top a number",
                            scene.source)
    if body.contact != "shared":
        raise InputError.at(key, body.interface, f'does not go with bodies.{i}.contact = "{body.contact}"',
                            scene.source)
    for other in scene.bodies:
        alike = other.interface and thickness_of(scene, other) == thickness_of(scene, body)
        if other.material == body.material and not alike:
            raise InputError.at(key, body.interface, f"needs a material that bodies of another kind or thickness do not"
                                f" have, as {other.name} does", scene.source)


def _refuse_beside(scene, key, points):
    solver = scene.solver
    if not TRANSFERS[solver.transfer].flip:
        allowed = " or ".join(f'"{name}"' for name, transfer in TRANSFERS.items() if transfer.flip)
        raise InputError.at(key, points, f'needs solver.transfer = {allowed} in place of "{solver.transfer}"',
                            scene.source)
    beside = {"switch": scene.switch, "zone": scene.zone,
              "water": scene.water, "initial.from": scene.initial.from_run is not None,
              'bodies with contact = "separate"': any(body.contact == "separate" for body in scene.bodies),
              'initial.relaxation = "static"': scene.initial.relaxation == "static"}
    if found := [name for name, there in beside.items() if there]:
        raise InputError.at(key, points, f"does not go with {' and '.join(found)}", scene.source)
