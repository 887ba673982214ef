"""The face of an obstacle as panels, and which nodes of the grid push on which panel.

Seen along the direction d of the push, an obstacle covers a rectangle of the plane across d: `across` to the left of d
in 3-D, `up` as close to the vertical as can be. The rectangle is cut into equal panels. A node pushes on the face where
the surface of the obstacle next to it looks against d; it spreads its push evenly over a square of one cell around it,
as far as snow can be there: not below the ground, nor beyond a closed side of the domain. So a uniform pressure stays
uniform on a wall along the grid, wherever panels and nodes lie.
"""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_matrix

from snowmpm.annotations import Floats
from snowmpm.errors import InputError

MARGIN = 3.0
"""Cells from the surface within which a node may get a push: the width of the cubic spline, and one."""
FACING = 0.05
"""Least cosine between d and the way into the surface."""
MOST = 20_000
"""Panels of an obstacle."""


@dataclass(frozen=True)
class Face:
    """direction, across, up: unit vectors, (dim,) each, across None in 2-D; front: of the obstacle along direction [m];
    first: coordinates [m] along across and up of the corner of the rectangle; counts, edges [m]: panels and their
    lengths along across and up."""

    direction: Floats
    front: float
    across: Floats | None
    up: Floats
    first: Floats
    counts: tuple[int, int]
    edges: Floats

    @classmethod
    def of(cls, shape, panels, bounds, key, source):
        """Of a `SolidShape` and the scene's table, as far as snow can be: bounds, (points, axis) -> lower and upper end
        of the snow along the axis (n,) [m], at each point; key of `size` and source of the scene. Raises InputError
        for no panels or too many."""
        d = np.array(panels.direction, float) / np.linalg.norm(panels.direction)
        across, up = plane_of(d)
        vertices = shape.drawing()[0]
        first, lengths, counts = np.zeros(2), np.ones(2), [1, 1]
        for k, axis in enumerate((across, up)):
            if axis is None:
                continue
            along, (low, high) = vertices @ axis, bounds(vertices, axis)
            known = low[np.isfinite(low)]  # beyond the terrain there is no snow, and no ground that ends it
            first[k] = max(along.min(), known.min()) if len(known) else along.min()
            lengths[k] = min(along.max(), high.max()) - first[k]
            if lengths[k] <= 0.0:
                raise InputError.at(key, panels.size, "finds no face above the ground to cut up", source)
            counts[k] = max(1, int(np.ceil(lengths[k] / panels.size - 1e-9)))
        if counts[0] * counts[1] > MOST:
            allowed = f"must give at most {MOST} panels, not {counts[0]} x {counts[1]}"
            raise InputError.at(key, panels.size, allowed, source)
        return cls(d, float((vertices @ d).min()), across, up, first, (counts[0], counts[1]), lengths / counts)

    @property
    def area(self):
        """Of a panel [m2]; in 2-D of a metre of width."""
        return float(self.edges[0] * self.edges[1])

    def about(self):
        """What a run file says of it, anything JSON can hold."""
        return {"direction": self.direction.tolist(), "front": self.front, "up": self.up.tolist(),
                "across": None if self.across is None else self.across.tolist(), "first": self.first.tolist(),
                "counts": list(self.counts), "edges": self.edges.tolist()}

    def shares(self, points, normals, dx, bounds):
        """Sparse (panels, n): shares of a node's push on each panel, rows of panels from below, in each from the first
        along `across`. points (n, dim) [m], outward normals (n, dim); bounds: axis -> lower and upper end of the snow
        along it (n,) [m], at each point."""
        n, columns, weights = len(points), [], []
        for k, axis in enumerate((self.across, self.up)):
            if axis is None:
                columns.append(np.zeros((n, 1), int))
                weights.append(np.ones((n, 1)))
                continue
            low, high = (end - self.first[k] for end in bounds(axis))
            places, parts = _overlaps(points @ axis - self.first[k], self.edges[k], self.counts[k], dx, low, high)
            columns.append(places)
            weights.append(parts)
        panel = columns[1][:, :, None] * self.counts[0] + columns[0][:, None, :]
        share = weights[1][:, :, None] * weights[0][:, None, :]
        share = share * (normals @ self.direction < -FACING)[:, None, None]
        node = np.broadcast_to(np.arange(n)[:, None, None], panel.shape)
        found = csr_matrix((share.ravel(), (panel.ravel(), node.ravel())), (self.counts[0] * self.counts[1], n))
        found.eliminate_zeros()
        return found


def plane_of(direction):
    """Unit vectors across a direction (dim,): to its left (None in 2-D), and up."""
    if len(direction) == 2:
        up = np.array([-direction[1], direction[0]])
        return None, up if up[1] > 0.0 or (up[1] == 0.0 and up[0] > 0.0) else -up
    vertical = np.array([0.0, 0.0, 1.0])
    if abs(direction[2]) > 0.99:  # a roof: up in plan
        vertical = np.array([0.0, 1.0, 0.0])
    up = vertical - (vertical @ direction) * direction
    up /= np.linalg.norm(up)
    return np.cross(up, direction), up


def _overlaps(middle, edge, count, width, lower, upper):
    """Panels (n, k) that intervals of some width around a middle (n,) overlap between lower and upper (n,), and the
    share of each (n, k). What lies beyond these or the face counts for the panel next to it."""
    lower, upper = (np.clip(end, 0.0, edge * count) for end in (lower, np.maximum(lower, upper)))
    low, high = (np.clip(middle + side, lower, upper) for side in (-0.5 * width, 0.5 * width))
    first = np.minimum((low / edge).astype(int), count - 1)
    wide = int(np.ceil(width / edge)) + 1
    places = first[:, None] + np.arange(wide)
    parts = np.clip(np.minimum(high[:, None], (places + 1) * edge) - np.maximum(low[:, None], places * edge), 0.0, None)
    parts[places >= count] = 0.0
    beyond = parts.sum(axis=1) <= 1e-9 * width
    parts[beyond] = 0.0
    parts[beyond, 0] = 1.0
    return np.minimum(places, count - 1), parts / parts.sum(axis=1, keepdims=True)
