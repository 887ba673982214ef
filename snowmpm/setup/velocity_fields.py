"""Velocity fields of bodies, and the friction between them."""

import numpy as np

from snowmpm.errors import InputError
from snowmpm.particles.blocks import MOST_FIELDS


def velocity_fields(scene):
    """Number of the velocity field of each body: 0 for bodies that share one. Raises InputError for too many."""
    separate = [body.contact == "separate" for body in scene.bodies]
    if sum(separate) >= MOST_FIELDS:
        raise InputError(f'{scene.source}: bodies: at most {MOST_FIELDS - 1} may have contact = "separate"')
    return np.where(separate, np.cumsum(separate), 0)


def body_friction(scene):
    """Coulomb coefficient between velocity fields (n, n)."""
    friction = np.full(1 + sum(body.contact == "separate" for body in scene.bodies), np.inf)
    for body, field in zip(scene.bodies, velocity_fields(scene), strict=True):
        if field > 0:
            friction[field] = body.friction
    return np.minimum(friction[:, None], friction)
