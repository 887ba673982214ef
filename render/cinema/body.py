"""The snow of a frame as a closed surface with a fine relief, and its loose particles as clods."""

from dataclasses import dataclass

import numpy as np
import trimesh
from scipy import ndimage
from scipy.spatial import cKDTree

from snowmpm.render.crumble import CRUMBS, crumbled
from snowmpm.render.snow import BALL
from snowmpm.render.snow_surface import CUBE, neighbour_means, snow_surface, vertex_normals

RELIEF = ((1.6, 0.30), (0.7, 0.25), (0.35, 0.15))
"""Sizes of the relief and its heights, in spacings of the particles: what the grid of the run does not resolve."""

CLOSE_RELIEF = ((0.25, 0.10), (0.16, 0.06))
CLOSE = 8.0
"""What comes to it in close views, and the pixels of a spacing that make one."""

SEEN = 5.0
"""Pixels from which a relief counts in full."""

FLOW_RELIEF = ((2.5, 0.16), (1.1, 0.07))
"""The same of a depth-averaged flow, in cells of its sheet."""

SMOOTHED = 0.8
"""Cells of a sheet over which its depth is smoothed: single columns are not seen."""

THIN = 0.06
"""Depth of a flow, in cells, below which the ground is seen."""

SHAPES, TURNS = 7, 101
"""Different clods, and ways in which they lie."""

EVENING = 2
"""Passes in which the surface is smoothed: enough against the lattice of the particles, not so many that it melts."""

COARSE = 2.0
"""Side of a cube of the surface of a preview, in radii of a particle."""

EVENED = 1
"""Passes in which the fine relief is evened out along the edges of the surface."""

LUMPY = 0.45
"""Of the radius of a clod: how far its surface goes in and out."""

ROUND = 0.35
"""Share of a clod's own normals in those by which it is lit."""

FULL, PLAIN = 80, 20
"""Faces of a clod near by, and far away."""

LIFT = 0.4
"""Of a spacing: lift of the surface (`Body`)."""

FACES = 1_200_000
"""Of all clods together at most; beyond, all are plain ones, and then only so many are drawn."""


@dataclass(frozen=True)
class Body:
    """vertices, normals (n, 3), faces (m, 3), velocity (n, 3) [m/s]; lift (n,) [m]: how far towards the light a vertex
    lies below the balls around the particles, by which they throw their shadow."""

    vertices: np.ndarray
    faces: np.ndarray
    normals: np.ndarray
    velocity: np.ndarray
    lift: np.ndarray

    @classmethod
    def of(cls, bodies):
        """One of several; without any, one of nothing."""
        count, faces = 0, [np.zeros((0, 3), np.int32)]
        for body in bodies:
            faces.append(body.faces + count)
            count += len(body.vertices)
        rows = [np.zeros((0, 10)), *(np.column_stack([body.vertices, body.normals, body.velocity, body.lift])
                                     for body in bodies)]
        vertices, normals, velocity, lift = np.split(np.concatenate(rows).astype(np.float32), (3, 6, 9), axis=1)
        faces = np.concatenate(faces).astype(np.int32)
        return cls(np.ascontiguousarray(vertices), faces, normals, velocity, lift[:, 0])


def snow_body(points, velocity, spacing, reference=None, loose=None, size_px=0.0, coarse=False):
    """The `Body` of the surface around particles, `spacing` [m] apart.

    points, velocity (k, 3); reference (k, 3): where they were at first, to which the relief of the surface sticks, or
    None; loose (k,): those that are no part of it; size_px: pixels of a spacing;
    coarse: a few times faster, for a preview
    """
    kept = np.ones(len(points), bool) if loose is None else ~loose
    if not kept.any():
        return Body.of([])
    vertices, faces, _ = snow_surface(np.ascontiguousarray(points[kept], np.float32), spacing, {}, evening=EVENING,
                                      cube=COARSE if coarse else CUBE)
    close = size_px > CLOSE and not coarse
    if close:
        vertices, faces = trimesh.remesh.subdivide(vertices, faces)
        vertices, faces = vertices.astype(np.float32), faces.astype(np.int32)
    nearest = np.flatnonzero(kept)[cKDTree(points[kept]).query(vertices)[1]]
    normals = vertex_normals(vertices, faces)
    if reference is not None:
        place = reference[nearest] + (vertices - points[nearest])
        relief = RELIEF + (CLOSE_RELIEF if close else ())
        # What is smaller than a few pixels would only make the snow grey
        height = sum(weight * spacing * min(1.0, size * size_px / SEEN) * noise(place / (size * spacing))
                     for size, weight in relief)
        # Beside each other lie particles from different places, and their noise would stand up like hair
        mean = neighbour_means(faces, len(vertices))
        for _ in range(EVENED):
            height = 0.5 * (height + mean @ height)
        vertices = (vertices + height[:, None] * normals).astype(np.float32)
        normals = vertex_normals(vertices, faces)
    return Body(vertices, faces, normals, velocity[nearest], np.full(len(vertices), LIFT * spacing))


def flow_body(sheet, ground, finer=1):
    """The `Body` of the surface of a `Sheet`, down to the ground at its rim.

    ground(x, y): its height [m]; finer: vertices for one place of the sheet, each way
    """
    low = np.array([sheet.row.min(), sheet.column.min()]) - 2
    depth = np.zeros(np.array([sheet.row.max(), sheet.column.max()]) + 3 - low)
    depth[sheet.row - low[0], sheet.column - low[1]] = sheet.depth
    depth = ndimage.gaussian_filter(depth, SMOOTHED)
    fine = ndimage.zoom(depth, finer, order=1, grid_mode=False)
    row, column = (np.linspace(0.0, n - 1.0, m) for n, m in zip(depth.shape, fine.shape, strict=True))
    first = np.array([sheet.x[0], sheet.y[0]]) + sheet.cell * (low - [sheet.row[0], sheet.column[0]])
    x, y = (part.ravel() for part in np.meshgrid(first[0] + sheet.cell * row, first[1] + sheet.cell * column,
                                                 indexing="ij"))
    fine = fine.ravel()
    place = np.column_stack([x, y, np.zeros(len(x))]) / sheet.cell
    rough = sum(weight * noise(place / size) for size, weight in FLOW_RELIEF)
    height = ground(x, y)
    on = np.isfinite(height) & (fine > THIN * sheet.cell)
    vertices = np.column_stack([x, y, np.where(on, height, 0.0) + fine + rough * np.minimum(fine, sheet.cell)])
    number = np.arange(len(x), dtype=np.int32).reshape(len(row), len(column))
    a, b, c, d = (part.ravel() for part in (number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]))
    faces = np.concatenate([np.column_stack([a, b, c]), np.column_stack([a, c, d])])
    faces = faces[on[faces].all(axis=1)]
    kept, faces = np.unique(faces, return_inverse=True)
    vertices, faces = vertices[kept].astype(np.float32), faces.reshape(-1, 3).astype(np.int32)
    return Body(vertices, faces, vertex_normals(vertices, faces), np.zeros_like(vertices),
                np.full(len(vertices), LIFT * sheet.cell, np.float32))


def noise(places):
    """Smooth noise in [-1, 1] (n,) over places (n, 3), of size 1."""
    table = np.random.default_rng(17).uniform(-1.0, 1.0, (48, 48, 48)).astype(np.float32)
    return ndimage.map_coordinates(table, np.asarray(places, np.float64).T % 48.0, order=1, mode="grid-wrap")


def clods(points, velocity, spacing, identity, size_px):
    """The `Body` of clods in place of loose particles (k, 3), the same in every frame.

    identity (k,): whole numbers that stay with their particles, or None; size_px: pixels of a spacing
    """
    pieces, sizes, *rest = crumbled(points, spacing, np.ones(len(points), bool), identity, velocity)
    fine = size_px > 6.0 and len(pieces) * FULL <= FACES
    most = FACES // (FULL if fine else PLAIN)
    # By the number of its particle, so that a clod looks the same whichever others there are
    of = np.repeat(np.arange(len(points)), CRUMBS) if identity is None else rest[0]
    number = of.astype(np.int64) * CRUMBS + np.tile(np.arange(CRUMBS), len(points))
    some = number % max(1, -(-len(pieces) // most)) == 0
    pieces, sizes, speeds, number = pieces[some], 0.5 * sizes[some], rest[1][some], number[some]
    shapes = [_lump(k, 1 if fine else 0) for k in range(SHAPES)]
    kind, turn = number % SHAPES, _turns(TURNS)[number % TURNS]
    found = []
    for k, (corners, faces, normals) in enumerate(shapes):
        own = np.flatnonzero(kind == k)
        if not len(own):
            continue
        placed = np.einsum("pij,vj->pvi", turn[own], corners) * sizes[own, None, None] + pieces[own, None]
        # Light goes through small lumps: they are brighter all round than their sides face
        facing = ROUND * np.einsum("pij,vj->pvi", turn[own], normals) + [0.0, 0.0, 1.0 - ROUND]
        facing /= np.maximum(np.linalg.norm(facing, axis=-1, keepdims=True), 1e-9)
        numbers = faces[None] + (len(corners) * np.arange(len(own)))[:, None, None]
        found.append(Body(placed.reshape(-1, 3), numbers.reshape(-1, 3), facing.reshape(-1, 3),
                          np.repeat(speeds[own], len(corners), axis=0),
                          np.full(corners.shape[0] * len(own), 2.0 * BALL * spacing)))
    return Body.of(found)


def _lump(k, fineness):
    """Corners (n, 3), faces and normals of an uneven ball of radius 1."""
    ball = trimesh.creation.icosphere(subdivisions=fineness)
    corners = np.asarray(ball.vertices)
    corners = corners * (1.0 + LUMPY * noise(1.3 * corners + 7.0 * k))[:, None]
    return corners, np.asarray(ball.faces, np.int64), vertex_normals(corners, np.asarray(ball.faces))


def _turns(n):
    """Rotations (n, 3, 3), the same in every frame: from unit quaternions."""
    q = np.random.default_rng(23).normal(size=(n, 4))
    w, x, y, z = (q / np.linalg.norm(q, axis=1, keepdims=True)).T
    return np.stack([1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y),
                     2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x),
                     2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)], axis=-1).reshape(-1, 3, 3)

