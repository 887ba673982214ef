"""Initial stress in balance with the weight of the snow above.

Snow cover on a slope (distance d below its surface, upward normal n, gravity g; an infinite slope is in exact balance):

    tau = rho d [ (g.n) (n n + K_0 (I - n n)) + g_t n + n g_t ],   g_t = g - (g.n) n,   K_0 = nu / (1 - nu)

summed over the layers above. Other bodies: the same with n up, d the depth below the highest particle of the same body
in the particle's column of one cell. K_0 is the elastic value of lateral confinement (validation case M14), unless the
scene gives one. At the free end of a layer these stresses are not in balance: the end moves at a speed of about
sigma / rho c (1 to 4 % of sqrt(g D) for a stiff slab of 1 m), which only settling removes
(`snowmpm.stepping.settling`).
"""

import numpy as np

from snowmpm.errors import InputError


def geostatic_stress(positions, normal_depth_load, normals, gravity, k0, shear=1.0):
    """Kirchhoff stress (n, 3, 3) [Pa], tensor axes 0 .. dim - 1 those of the scene, axis 2 out of plane in 2-D.

    normal_depth_load: overburden rho d of each particle [kg/m2] (n,); normals (n, dim); gravity (dim,); k0 (n,).
    shear: share of the shear stress, (n,) or a number.
    """
    n, dim = normals.shape
    normal = np.zeros((n, 3))
    normal[:, :dim] = normals
    g = np.zeros(3)
    g[:dim] = gravity
    g_n = normal @ g
    g_t = g - g_n[:, None] * normal
    nn = normal[:, :, None] * normal[:, None, :]
    along = np.reshape(shear, (-1, 1, 1)) * g_t[:, :, None] * normal[:, None, :]
    confined = nn + k0[:, None, None] * (np.eye(3) - nn)
    return normal_depth_load[:, None, None] * (g_n[:, None, None] * confined + along + along.transpose(0, 2, 1))


def overburden(bodies, positions, body_of, surface_query, gravity, dx, spacing):
    """Mass per area above each particle along the terrain's normal [kg/m2], and that normal.

    bodies: [(layer shape or None, density)], in the order of `body_of` (n,).
    surface_query: points -> distance, normal, or None without terrain. spacing: distance between particles [m].
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
        load[layered] = _layers_above(bodies, distance, columns[layered], body_of[layered], spacing)
    for body in np.unique(body_of[~layered]):
        own = body_of == body
        load[own] = bodies[body][1] * _depth_in_column(columns[own], positions[own, -1], spacing)
    return load, normals


def _cell_ids(columns):
    """Integer label of the plan cell of each row of `columns` (n, dim - 1)."""
    _, label = np.unique(columns, axis=0, return_inverse=True)
    return label.reshape(-1)


def _layers_above(bodies, distance, columns, body_of, spacing):
    load, cell = np.zeros(len(distance)), _cell_ids(columns)
    for i, (layer, density) in enumerate(bodies):
        if layer is None:
            continue
        own = body_of == i
        top = np.full(cell.max() + 1, -np.inf)  # of this layer over each plan cell; -inf without this layer
        highest = distance[own] + 0.5 * spacing if layer.top == "file" else layer.top
        np.maximum.at(top, cell[own], highest)
        load += density * np.clip(top[cell] - np.maximum(distance, layer.bottom), 0.0, None)
    return load


def _depth_in_column(columns, height, spacing):
    label = _cell_ids(columns)
    top = np.full(label.max() + 1, -np.inf)
    np.maximum.at(top, label, height)
    return top[label] - height + 0.5 * spacing
