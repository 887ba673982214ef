"""Terrain, sides of the domain and obstacles, as `held.Held` and `contact_set.ContactSet` ask for them."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from snowmpm.stepping.contact_velocity import CODES, SLIP, STICK


class Surface(NamedTuple):
    """distance(nodes (k, dim) [cells]) -> distance [cells] (k,), normal out of the solid (k, dim); code: of
    `stepping.contact_velocity`; friction: Coulomb mu [-]; obstacle: its number, -1 for the ground and sides; centre
    (dim,): of its moments [cells]."""

    distance: Callable
    code: int
    friction: float = 0.0
    obstacle: int = -1
    centre: np.ndarray | None = None

    @property
    def fixed(self):
        """Whether it holds what it touches always in the same way, and nobody asks for its forces."""
        return self.obstacle < 0 and (self.code == STICK or (self.code == SLIP and self.friction == 0.0))


def surfaces_of(frame, setting):
    """`Surface`s of the terrain, the sides and the obstacles, at rest, of a `Setting`."""
    found, sides = [], setting.walls
    if setting.ground:
        terrain, contact, friction = setting.ground
        code = CODES[contact]
        found.append(Surface(_of_query(frame, terrain.query), code, 0.0 if code == STICK else friction))
    levels = np.stack([frame.lower, frame.upper], axis=1)
    for axis in range(frame.dim):
        for end in range(2):
            if sides[axis][end] not in ("open", "periodic"):
                found.append(Surface(_of_side(frame.dim, axis, 1 - 2 * end, levels[axis, end]),
                                     CODES[sides[axis][end]]))
    for i, obstacle in enumerate(setting.obstacles):
        centre = (obstacle.motion.pose(0.0).centre - frame.origin) / frame.dx
        found.append(Surface(_of_query(frame, _at_rest(obstacle)), obstacle.code,
                             0.0 if obstacle.code == STICK else obstacle.friction, i, centre))
    return found


def _at_rest(obstacle):
    return lambda points: obstacle.query_at(points, 0.0)


def _of_query(frame, query):
    def distance(nodes):
        found, normal = query(frame.origin + frame.dx * nodes)
        return found / frame.dx, normal

    return distance


def _of_side(dim, axis, sign, level):
    def distance(nodes):
        return sign * (nodes[:, axis] - level), np.broadcast_to(sign * np.eye(dim)[axis], nodes.shape)

    return distance
