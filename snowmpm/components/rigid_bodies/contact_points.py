"""Where bodies touch each other and what stands still: points, normals, gaps."""

from dataclasses import dataclass
from typing import Any

import numpy as np

DIRECTIONS = 8
"""Along which the outermost points of a patch of contact are kept in 3-D."""

FLAT = 1e-6
"""Share of the width of a patch by which its deepest point must lie deeper than the outermost ones to count."""

INSET = 5e-3
"""Share of the way to the centre of its body by which a probe is moved in to be asked for distance and normal, which
then says how far out the probe is. Where two corners meet, the normal at the corner itself is round-off."""


@dataclass(frozen=True, eq=False)
class ContactPoints:
    """Points at which a `Body` meets a surface.

    first: the body whose probes they are; second: the body of the surface, None of what is not free; surface: its
    number; numbers (k,) of the probes; points (k, dim) [m]; normals (k, dim) out of the surface; gaps (k,) [m], < 0
    where they overlap; velocity (k, dim) [m/s] of a surface that is not free; friction, restitution [-].
    """

    first: Any
    second: Any
    surface: int
    numbers: np.ndarray
    points: np.ndarray
    normals: np.ndarray
    gaps: np.ndarray
    velocity: np.ndarray
    friction: float
    restitution: float

    @classmethod
    def of(cls, first, second, surface, query, margin, velocity=np.zeros_like):
        """-> list of the touch, if any, of a body with a surface nearer than `margin` [m], and the least gap [m].

        query(points) -> distance, normal of the surface; velocity(points) [m/s] of one that is not free.
        """
        points, radius = first.probes
        inset = INSET * (first.motion.centre - points)  # of a ball: none
        distance, normals = query(points + inset)
        gaps = distance - radius - (normals * inset).sum(axis=1)
        near = np.flatnonzero(gaps < margin)
        if not len(near):
            return [], float(gaps.min())
        chosen = near[outermost(points[near], normals[near], gaps[near])]
        points, normals = points[chosen] - radius * normals[chosen], normals[chosen]
        friction, bounce = first.friction, first.restitution
        if second is not None:
            friction, bounce = min(friction, second.friction), max(bounce, second.restitution)
        return [cls(first, second, surface, chosen, points, normals, gaps[chosen], velocity(points), friction,
                    bounce)], float(gaps.min())


def outermost(points, normals, gaps):
    """Numbers of the points that carry a contact: the outermost ones, and the deepest.

    A rigid body that lies on many points rests on the corners of their hull: more of them leave the forces without a
    unique answer, and the motion as it is.
    """
    dim = points.shape[1]
    if len(points) <= (2 if dim == 2 else 4):
        return np.arange(len(points))
    mean = normals.mean(axis=0)
    mean /= max(np.linalg.norm(mean), 1e-300)
    if dim == 2:
        along = np.array([[-mean[1], mean[0]]])
    else:
        across = tangents(mean[None])[0]
        angle = np.pi * np.arange(DIRECTIONS // 2) / (DIRECTIONS // 2)
        along = np.cos(angle)[:, None] * across[0] + np.sin(angle)[:, None] * across[1]
    places = points @ along.T
    chosen = [*places.argmax(axis=0), *places.argmin(axis=0)]
    deepest = int(np.argmin(gaps))
    if gaps[deepest] < gaps[chosen].min() - FLAT * np.ptp(places):
        chosen.append(deepest)
    return np.unique(chosen)


def tangents(normals):
    """Unit vectors (k, dim - 1, dim) across unit normals (k, dim)."""
    if normals.shape[1] == 2:
        return np.stack([-normals[:, 1], normals[:, 0]], axis=1)[:, None]
    least = np.eye(3)[np.abs(normals).argmin(axis=1)]
    first = np.cross(normals, least)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    return np.stack([first, np.cross(normals, first)], axis=1)
