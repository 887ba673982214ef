"""Defects of a terrain that is still usable, reported to the user."""

import numpy as np

from snowmpm.terrain import topology

LAYER = 1e-6
"""Share of a surface's size below which two facets over one place are one: coordinates of a file are rounded."""


def defects(vertices, facets, surface):
    """Texts on what `surface` (`TerrainSurface`), made of raw vertices (n, 3) and triangles (m, 3), contains or
    has repaired: holes, triangles above others, flipped triangles, duplicate or degenerate triangles."""
    found = []
    if holes := n_holes(surface):
        found.append(f"{_count(holes, 'hole')}, where nothing is carried")
    if layered := in_layers(surface):
        found.append(layered)
    if flipped := n_flipped(vertices, facets, surface):
        found.append(f"{_count(flipped, 'triangle')} that faced the other way, turned")
    if dropped := len(facets) - len(surface.facets):
        found.append(f"{_count(dropped, 'triangle')} twice or without area, left out")
    return found


def n_holes(surface):
    """Closed border lines inside an open surface: all but the outer one of each part."""
    joint, _, n_joints = topology.joints(surface.facets, len(surface.vertices))
    count = np.bincount(joint.ravel(), minlength=n_joints)
    border = count[joint] == 1
    start, end = surface.facets[border], np.roll(surface.facets, -1, axis=1)[border]
    if surface.closed or not len(start):
        return 0
    n = len(surface.vertices)
    line = _parts(n, start, end)
    part = _parts(n, surface.facets.ravel(), np.roll(surface.facets, -1, axis=1).ravel())
    return len(np.unique(line[start])) - len(np.unique(part[start]))


def in_layers(surface):
    """Text on triangles of an open surface that lie over or under others, an overhang or a second layer, or ""."""
    if surface.closed:
        return ""
    gap, middle = surface.layers()
    twofold = gap > LAYER * float(np.max(surface.upper - surface.lower))
    if not twofold.any():
        return ""
    widest = gap.argmax()
    x, y = middle[widest]
    return (f"{_count(int(twofold.sum()), 'triangle')} over or under others, {gap[widest]:.3g} m apart at x = {x:.10g},"
            f" y = {y:.10g}: an overhang or a second layer, of which the highest carries the snow at the start")


def n_flipped(vertices, facets, surface):
    """Triangles whose normal pointed another way than that of most, where the ground has no overhang."""
    if surface.closed or (surface.facet_normals[:, -1] <= 0.0).any():
        return 0
    a, b, c = (vertices[facets[:, k], :2] for k in range(3))
    area = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0])
    return int(min((area > 0.0).sum(), (area < 0.0).sum()))


def _parts(n, start, end):
    """The least number in the connected part of each of n vertices, of edges start - end.

    SciPy's graphs take longer to import than an ordinary terrain to load.
    """
    part = np.arange(n)
    while True:
        below, least = part.copy(), np.minimum(part[start], part[end])
        for side in (start, end):
            np.minimum.at(below, part[side], least)
        while (below[below] != below).any():
            below = below[below]
        if (below == part).all():
            return part
        part = below


def _count(n, noun):
    return f"{n} {noun}" + ("s" if n > 1 else "")
