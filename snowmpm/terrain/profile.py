"""A slope given by its profile: points joined by straight lines, corners rounded if wished."""

import numpy as np

from snowmpm.errors import InputError

ARC_STEP = np.radians(1.0)  # turn between the chords of a rounded corner: they leave the arc by 4e-5 of the radius


def profile_facets(points, fillet=0.0):
    """Vertices (n, 2) and segments (n - 1, 2) of a profile.

    points: (x, z) [m], x never decreasing (or never increasing: the order is turned); fillet: radius [m] of the arc put
    into every inner corner, 0 for none.
    """
    points = np.asarray(points, float)
    if points.ndim != 2 or points.shape[1] != 2 or len(points) < 2:
        raise InputError("terrain.points: at least two points [x, z] are needed")
    if points[-1, 0] < points[0, 0]:
        points = points[::-1]
    back = np.flatnonzero(np.diff(points[:, 0]) < 0)
    if len(back):
        i = int(back[0])
        raise InputError(f"terrain.points: x must not turn back, but {points[i + 1, 0]:g} follows {points[i, 0]:g}")
    points = points[np.r_[True, np.linalg.norm(np.diff(points, axis=0), axis=1) > 0]]
    if len(points) < 2 or points[-1, 0] <= points[0, 0]:
        raise InputError("terrain.points: the profile has no horizontal extent")
    if fillet:
        points = rounded(points, fillet)
    n = np.arange(len(points) - 1)
    return points, np.column_stack([n, n + 1])


def drawn_out(points, width):
    """Vertices (2n, 3) and triangles (2n - 2, 3) of a profile (n, 2) extruded along y over `width` (y0, y1) [m]."""
    n = len(points)
    near, far = (np.insert(points, 1, y, axis=1) for y in width)
    k = np.arange(n - 1)
    return np.concatenate([near, far]), np.concatenate([np.column_stack([k, k + 1, k + 1 + n]),
                                                        np.column_stack([k, k + 1 + n, k + n])])


def rounded(points, radius):
    """The polyline (n, 2) with an arc of `radius` [m], tangent to both sides, in place of each inner corner."""
    if radius < 0:
        raise InputError.at("terrain.fillet", radius, "must be >= 0")
    edge = np.diff(points, axis=0)
    length = np.linalg.norm(edge, axis=1)
    direction = edge / length[:, None]
    u, v = direction[:-1], direction[1:]
    turn = np.arctan2(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0], (u * v).sum(axis=1))
    tangent = np.r_[0.0, radius * np.tan(0.5 * np.abs(turn)), 0.0]
    room = length - tangent[:-1] - tangent[1:]
    if (room < -1e-9 * length).any():
        i = int(np.argmin(room))
        fits = radius * length[i] / (tangent[i] + tangent[i + 1])
        side = f"from {points[i].tolist()} to {points[i + 1].tolist()}"
        raise InputError.at("terrain.fillet", radius, f"the side {side} is too short; at most {fits:.4g} m fits")
    parts = [points[:1]]
    for i, angle in enumerate(turn):
        n = max(int(np.ceil(abs(angle) / ARC_STEP - 1e-9)), 1)
        phi = angle * np.arange(n + 1) / n
        left = np.array([-u[i, 1], u[i, 0]]) * np.sign(angle)
        start = points[i + 1] - tangent[i + 1] * u[i]
        arc = start + radius * (np.sin(np.abs(phi))[:, None] * u[i] + (1.0 - np.cos(phi))[:, None] * left)
        parts.append(arc if abs(angle) > 1e-12 else points[i + 1 : i + 2])
    return np.concatenate([*parts, points[-1:]])
