"""Bodies that slide on others and part: their keys, their velocity fields, and the friction between them."""

from typing import Literal

import numpy as np

from snowmpm.components.contract import Component
from snowmpm.errors import InputError
from snowmpm.registry import COMPONENTS
from snowmpm.scenes.spec import NonNegative, Spec


class OfBody(Spec):
    """Keys of a body."""

    contact: Literal["shared", "separate"] = "shared"
    """shared: bodies that touch move as one continuum; separate: this body may slide on others and separate from
    them"""
    friction: NonNegative = 0.3
    """Coulomb coefficient of a separate body against the others; between two such bodies the smaller value applies
    [-]"""


def asked(scene):
    """(key, value) of each body that may part from others."""
    for i, body in enumerate(scene.bodies):
        if body.contact == "separate":
            yield f"bodies.{i}.contact", body.contact


def velocity_fields(scene):
    """Number of the velocity field of each body: 0 for bodies that share one."""
    separate = [body.contact == "separate" for body in scene.bodies]
    return np.where(separate, np.cumsum(separate), 0)


def body_friction(scene):
    """Coulomb coefficient between velocity fields (n, n)."""
    friction = np.full(1 + sum(body.contact == "separate" for body in scene.bodies), np.inf)
    for body, field in zip(scene.bodies, velocity_fields(scene), strict=True):
        if field > 0:
            friction[field] = body.friction
    return np.minimum(friction[:, None], friction)


def refuse_many(scene):
    """Raise InputError for more velocity fields than there can be."""
    from snowmpm.particles.blocks import MOST_FIELDS  # it needs the compiler, a scene does not

    if sum(body.contact == "separate" for body in scene.bodies) >= MOST_FIELDS:
        raise InputError(f'{scene.source}: bodies: at most {MOST_FIELDS - 1} may have contact = "separate"')


COMPONENTS.add(Component(
    "body_contact", __package__, "bodies that part", asked, order=10, keys={"bodies": OfBody},
    rests=True,
    owns=("the velocity fields of nodes",), beside=('water.scheme = "v_w"',), refuse=refuse_many,
    fields=velocity_fields, cautions=f"{__package__}.cautions", atlas=f"{__package__}.atlas"))
