"""The surface of the snow as a mesh, by pysplashsurf.

Marching cubes on the density of spheres around the particles (Loeschner et al. 2023, doi:10.2312/vmv.20231245).
"""

import numpy as np
from scipy import sparse
from scipy.spatial import cKDTree

SMOOTHING, CUBE, THRESHOLD = 2.0, 1.2, 0.6
"""Smoothing length and side of a cube, in radii of a particle, and level of the surface: as the library advises."""

EVENING = 10
"""Passes of its smoothing, which leaves the volume."""


def snow_surface(points, spacing, fields, flat=False, evening=EVENING, cube=CUBE):
    """Vertices (n, 3) [m], faces (m, 3), and the fields of the nearest particle at each vertex.

    points (k, 3) [m]; flat: a section in x and z, which becomes a slice three particles thick; evening: passes of the
    library's smoothing; cube: side of a cube, in radii.
    """
    import pysplashsurf

    if not len(points):
        return np.zeros((0, 3), np.float32), np.zeros((0, 3), np.int32), fields
    radius = 0.5 * spacing
    source = np.arange(len(points))
    if flat:
        source = np.tile(source, 3)
        shift = np.repeat([[0.0, -spacing, 0.0], [0.0, 0.0, 0.0], [0.0, spacing, 0.0]], len(points), axis=0)
        points = points[source] + shift.astype(np.float32)
    low = points.min(axis=0)  # in float32, near zero
    mesh, _ = pysplashsurf.reconstruction_pipeline(
        np.ascontiguousarray(points - low, np.float32), particle_radius=radius, rest_density=1000.0,
        smoothing_length=SMOOTHING, cube_size=cube, iso_surface_threshold=THRESHOLD, mesh_smoothing_weights=True,
        mesh_smoothing_iters=evening, mesh_cleanup=True, decimate_barnacles=True, multi_threading=True)
    vertices, faces = np.asarray(mesh.mesh.vertices), np.asarray(mesh.mesh.triangles, np.int32)
    nearest = source[cKDTree(points - low).query(vertices)[1]] if len(vertices) else np.zeros(0, int)
    return (vertices + low).astype(np.float32), faces, {name: values[nearest] for name, values in fields.items()}


def vertex_normals(points, faces):
    """Unit normals (n, 3) float32 of vertices (n, 3): means of those of their triangles (m, 3), by area."""
    corners = points[faces].astype(np.float64)
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    total = np.stack([np.bincount(faces.ravel(), np.repeat(cross[:, axis], 3), len(points)) for axis in range(3)], -1)
    length = np.linalg.norm(total, axis=1, keepdims=True)
    return np.where(length > 0.0, total / np.maximum(length, 1e-300), [0.0, 0.0, 1.0]).astype(np.float32)


def neighbour_means(faces, n):
    """Sparse matrix (n, n) that gives each of n vertices the mean of those it shares an edge of faces (m, 3) with."""
    a = np.concatenate([faces[:, k] for k in (0, 1, 2, 1, 2, 0)])
    b = np.concatenate([faces[:, k] for k in (1, 2, 0, 0, 1, 2)])
    edges = sparse.csr_matrix((np.ones(len(a), np.float32), (a, b)), shape=(n, n))
    return sparse.diags(1.0 / np.maximum(np.asarray(edges.sum(axis=1)).ravel(), 1.0)).astype(np.float32) @ edges
