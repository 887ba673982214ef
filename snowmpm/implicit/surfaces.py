"""Terrain and sides of the domain, as `held.Held` asks for them."""

import numpy as np

from snowmpm.stepping.contact_velocity import CODES


def surfaces_of(frame, terrain, contact, sides):
    """[(distance, code)] of a terrain (object with `query`, or None) with its contact, and of sides, (dim, 2) names."""
    found = []
    if terrain is not None:
        found.append((_of_terrain(frame, terrain), CODES[contact]))
    levels = np.stack([frame.lower, frame.upper], axis=1)
    for axis in range(frame.dim):
        for end in range(2):
            if sides[axis][end] != "open":
                found.append((_of_side(frame.dim, axis, 1 - 2 * end, levels[axis, end]), CODES[sides[axis][end]]))
    return found


def _of_terrain(frame, terrain):
    def distance(nodes):
        found, normal = terrain.query(frame.origin + frame.dx * nodes)
        return found / frame.dx, normal

    return distance


def _of_side(dim, axis, sign, level):
    def distance(nodes):
        return sign * (nodes[:, axis] - level), np.broadcast_to(sign * np.eye(dim)[axis], nodes.shape)

    return distance
