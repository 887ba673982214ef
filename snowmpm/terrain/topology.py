"""Facets that belong together: welded vertices, one orientation, normals of edges and corners.

A facet is a segment in 2-D and a triangle in 3-D. What two facets share is called a joint here: a vertex in 2-D, an
edge in 3-D, so that one text serves both. All arrays: vertices (n, dim) [m], facets (m, dim).
"""

import numpy as np

WELD = 1e-9  # of the surface's size: vertices closer than this are one (STL repeats each vertex per triangle)
LARGEST = 1e12  # m: coordinates beyond are an error of the file, and squares of them must fit a number
FLAT = 1e-12  # of the surface's size squared (3-D) or size (2-D): facets smaller than this are dropped


def tidied(vertices, facets):
    """The same surface with shared vertices, without degenerate, repeated or unused parts."""
    dim = vertices.shape[1]
    size = float(np.ptp(vertices, axis=0).max()) if len(vertices) else 0.0
    if size == 0.0 or len(facets) == 0:
        return vertices[:0], facets[:0].astype(np.int32)
    cells = np.round((vertices - vertices.min(axis=0)) / (WELD * size)).astype(np.int64)
    order = np.lexsort(cells.T[::-1])
    first = np.ones(len(order), bool)
    first[1:] = (np.diff(cells[order], axis=0) != 0).any(axis=1)
    name = np.empty(len(order), np.int64)
    name[order] = np.cumsum(first) - 1
    vertices, facets = vertices[order[first]], name[facets]

    distinct = np.sort(facets, axis=1)
    facets = facets[(np.diff(distinct, axis=1) > 0).all(axis=1)]
    facets = facets[facet_measures(vertices, facets) > FLAT * size ** (dim - 1)]
    if len(facets) == 0:
        return vertices[:0], facets.astype(np.int32)
    _, keep = np.unique(_joined_key(np.sort(facets, axis=1), len(vertices)), return_index=True)
    facets = facets[np.sort(keep)]
    used, facets = np.unique(facets, return_inverse=True)
    return vertices[used], facets.reshape(-1, dim).astype(np.int32)


def _joined_key(rows, n):
    """One integer per row of vertex numbers below n; Python's own integers where 64 bits are too few."""
    if n ** rows.shape[1] < 2**62:
        return sum(rows[:, k].astype(np.int64) * n**k for k in range(rows.shape[1]))
    return np.array([sum(int(v) * n**k for k, v in enumerate(row)) for row in rows], dtype=object)


def _raw_normals(vertices, facets):
    """Normals whose length is the segment's length or twice the triangle's area."""
    corner = vertices[facets]
    if vertices.shape[1] == 2:
        edge = corner[:, 1] - corner[:, 0]
        return np.stack([-edge[:, 1], edge[:, 0]], axis=1)
    return np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])


def facet_measures(vertices, facets):
    """Length (2-D) [m] or area (3-D) [m2] of each facet, shape (m,)."""
    length = np.linalg.norm(_raw_normals(vertices, facets), axis=1)
    return length if vertices.shape[1] == 2 else 0.5 * length


def facet_normals(vertices, facets):
    """Unit normals (m, dim): to the left of a segment, right-handed about a triangle."""
    normal = _raw_normals(vertices, facets)
    return normal / np.linalg.norm(normal, axis=1, keepdims=True)


def joints(facets, n_vertices):
    """Number of each facet's joints and the direction in which the facet runs along them.

    -> joint (m, dim) int64, sign (m, dim) +-1, n_joints. Two facets with one orientation have opposite signs at their
    joint. In 3-D joint k of a triangle is the edge from corner k to corner k + 1; in 2-D joint k is corner k.
    """
    if facets.shape[1] == 2:
        return facets.astype(np.int64), np.tile([-1, 1], (len(facets), 1)), n_vertices
    start, end = facets.astype(np.int64), np.roll(facets, -1, axis=1).astype(np.int64)
    key = np.minimum(start, end) * n_vertices + np.maximum(start, end)
    _, joint = np.unique(key, return_inverse=True)
    joint = joint.reshape(facets.shape)
    return joint, np.where(start < end, 1, -1), int(joint.max()) + 1


def oriented(vertices, facets):
    """Facets turned so that their normals point out of the ground, and whether the surface is closed.

    Open parts face up. Each facet alone is turned by the sign of its vertical component; where that contradicts a
    neighbour (overhangs, cliffs), the orientation is carried from facet to facet and each connected part faces up on
    the whole. Closed parts (a block, a boulder) face outwards.
    """
    joint, sign, n_joints = joints(facets, len(vertices))
    count = np.bincount(joint.ravel(), minlength=n_joints)
    normal = _raw_normals(vertices, facets)
    up = np.where(normal[:, -1] < 0, -1, 1)
    mates = _mates(joint, sign, count)
    if _consistent(up, *mates) and (count == 1).any():
        return _turned(facets, up), False

    turn, part = _carried(len(facets), *mates)
    open_part = np.zeros(part.max() + 1, bool)
    open_part[part[(count[joint] == 1).any(axis=1)]] = True
    centre = vertices[facets].mean(axis=1) - vertices.mean(axis=0)
    # The flux of the position through a closed part is dim times its volume: positive when it faces outwards.
    lean = np.where(open_part[part], normal[:, -1], (normal * centre).sum(axis=1))
    total = np.bincount(part, weights=turn * lean)
    turn = turn * np.where(total < 0, -1, 1)[part]
    return _turned(facets, turn), not open_part.any()


def _turned(facets, turn):
    facets = facets.copy()
    flipped = turn < 0
    facets[flipped, 0], facets[flipped, 1] = facets[flipped, 1], facets[flipped, 0].copy()
    return facets


def _mates(joint, sign, count):
    """Pairs of facets at joints of exactly two, and +1 where they agree in orientation, -1 where not."""
    facet = np.repeat(np.arange(len(joint)), joint.shape[1])
    pairs = np.flatnonzero(count[joint.ravel()] == 2)
    pairs = pairs[np.argsort(joint.ravel()[pairs], kind="stable")].reshape(-1, 2)
    return facet[pairs[:, 0]], facet[pairs[:, 1]], -sign.ravel()[pairs[:, 0]] * sign.ravel()[pairs[:, 1]]


def _consistent(turn, first, second, agree):
    return bool((turn[first] * turn[second] * agree == 1).all())


def _carried(n, first, second, agree):
    """Turn (+-1) of each facet relative to the first of its connected part, and the part's number."""
    from scipy.sparse import coo_array, csgraph  # slow to import, and few surfaces are turned

    ends = first.astype(np.int32), second.astype(np.int32)  # what csgraph of SciPy 1.11 takes
    graph = coo_array((np.ones(len(first), np.int8), ends), shape=(n, n)).tocsr()
    n_parts, part = csgraph.connected_components(graph, directed=False)
    key = np.minimum(first, second) * n + np.maximum(first, second)
    order = np.argsort(key)
    turn = np.ones(n, np.int64)
    for root in np.unique(part, return_index=True)[1][:n_parts]:
        visit, parent = csgraph.breadth_first_order(graph, root, directed=False)
        children, parents = visit[1:], parent[visit[1:]]
        edge = np.minimum(children, parents).astype(np.int64) * n + np.maximum(children, parents)
        relation = agree[order[np.searchsorted(key, edge, sorter=order)]]
        for child, above, same in zip(children, parents, relation, strict=True):
            turn[child] = turn[above] * same
    return turn, part


def vertex_normals(vertices, facets):
    """Angle-weighted unit normals at the vertices (n, dim).

    The sign of the distance to a corner follows from them without exception; J. A. Baerentzen and H. Aanaes (2005),
    doi:10.1109/TVCG.2005.49.
    """
    normal, corner = facet_normals(vertices, facets), vertices[facets]
    weights = [_angle(corner, k) for k in range(facets.shape[1])]
    return _unit(_gathered(facets, normal, weights, len(vertices)))


def joint_normals(vertices, facets):
    """Number of each facet's joints (m, dim) int32 and the mean unit normal at each joint (n_joints, dim)."""
    if vertices.shape[1] == 2:
        return facets, vertex_normals(vertices, facets)
    joint, _, n_joints = joints(facets, len(vertices))
    total = _gathered(joint, facet_normals(vertices, facets), (1.0, 1.0, 1.0), n_joints)
    return joint.astype(np.int32), _unit(total)


def _gathered(target, vectors, weights, n):
    """Sum (n, dim) of weights[k] vectors[f] over all facets f and their places k with target[f, k] = row."""
    total = np.zeros((n, vectors.shape[1]))
    for k, weight in enumerate(weights):
        for axis in range(vectors.shape[1]):
            total[:, axis] += np.bincount(target[:, k], weights=weight * vectors[:, axis], minlength=n)
    return total


def _angle(corner, k):
    """Interior angle of each triangle at corner k; 1 for segments."""
    if corner.shape[1] == 2:
        return np.ones(len(corner))
    a = corner[:, (k + 1) % 3] - corner[:, k]
    b = corner[:, (k + 2) % 3] - corner[:, k]
    return np.arctan2(np.linalg.norm(np.cross(a, b), axis=1), (a * b).sum(axis=1))


def _unit(vectors):
    """Unit vectors; up where facets fold back on each other and leave no direction."""
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    up = np.zeros(vectors.shape[1])
    up[-1] = 1.0
    return np.where(length > 1e-12, vectors / np.maximum(length, 1e-300), up)
