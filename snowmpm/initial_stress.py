"""Stress at the start: in balance with the weight of the snow above.

Snow cover on a slope (distance d below its surface, upward normal n, gravity g; an infinite slope is in exact balance):

    tau = rho d [ (g.n) (n n + K_0 (I - n n)) + g_t n + n g_t ],   g_t = g - (g.n) n,   K_0 = nu / (1 - nu)

summed over the layers above. Other bodies: the same with n up, d the depth below the highest particle of the same body
in the particle's column of one cell. K_0 is the elastic value of lateral confinement (validation case M14).
"""

import numpy as np

from snowmpm.errors import InputError


def geostatic_stress(positions, normal_depth_load, normals, gravity, k0):
    """Kirchhoff stress (n, 3, 3) [Pa], tensor axes 0 .. dim - 1 those of the scene, axis 2 out of plane in 2-D.

    normal_depth_load: overburden rho d of each particle [kg/m2] (n,); normals (n, dim); gravity (dim,); k0 (n,).
    """
    n, dim = normals.shape
    normal = np.zeros((n, 3))
    normal[:, :dim] = normals
    g = np.zeros(3)
    g[:dim] = gravity
    g_n = normal @ g
    g_t = g - g_n[:, None] * normal
    nn = normal[:, :, None] * normal[:, None, :]
    shear = g_t[:, :, None] * normal[:, None, :]
    confined = nn + k0[:, None, None] * (np.eye(3) - nn)
    return normal_depth_load[:, None, None] * (g_n[:, None, None] * confined + shear + shear.transpose(0, 2, 1))


def overburden(bodies, positions, body_of, surface_query, gravity, dx):
    """Mass per area above each particle along the terrain's normal [kg/m2], and that normal.

    bodies: [(layer shape or None, density)], in the order of `body_of` (n,).
    surface_query: points -> distance, normal, or None without terrain.
    """
    n, dim = positions.shape
    load, normals = np.zeros(n), np.zeros((n, dim))
    up = -np.asarray(gravity, float)
    size = np.linalg.norm(up)
    normals[:] = up / size if size > 0.0 else np.eye(dim)[-1]
    columns = np.floor(positions[:, : dim - 1] / dx).astype(np.int64)
    layered = np.isin(body_of, [i for i, (layer, _) in enumerate(bodies) if layer is not None])
    if layered.any():
        if surface_query is None:
            raise InputError("initial.stress: layers need a terrain")
        distance, normals[layered] = surface_query(positions[layered])
        load[layered] = _layers_above(bodies, distance, columns[layered], columns, body_of)
    for body in np.unique(body_of[~layered]):
        own = body_of == body
        load[own] = bodies[body][1] * _depth_in_column(columns[own], positions[own, -1], dx)
    return load, normals


def _cell_ids(columns, among):
    """Integer label of each plan cell, the same for `columns` and `among`."""
    both = np.concatenate([columns, among])
    _, label = np.unique(both, axis=0, return_inverse=True)
    label = label.reshape(-1)
    return label[: len(columns)], label[len(columns):]


def _layers_above(bodies, distance, columns, all_columns, body_of):
    load = np.zeros(len(distance))
    here, everywhere = _cell_ids(columns, all_columns)
    for i, (layer, density) in enumerate(bodies):
        if layer is None:
            continue
        covered = np.isin(here, everywhere[body_of == i])
        thickness = np.clip(layer.top - np.maximum(distance, layer.bottom), 0.0, None)
        load += np.where(covered, density * thickness, 0.0)
    return load


def _depth_in_column(columns, height, dx):
    label, _ = _cell_ids(columns, columns[:0])
    top = np.full(label.max() + 1, -np.inf)
    np.maximum.at(top, label, height)
    return top[label] - height + 0.25 * dx
