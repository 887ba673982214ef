"""Obstacles and the saw of a film: finely divided, each with the colours that it has."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import trimesh

from snowmpm.render import light
from snowmpm.render.snow_surface import vertex_normals
from snowmpm.render.solid import SOLID
from snowmpm.render.upright import turned

CREASE = np.radians(30.0)
"""Angle between the faces of an obstacle above which their edge is sharp."""

MOST_FACES = 200_000
"""Of an obstacle that is finely divided."""


@dataclass(frozen=True)
class Solid:
    """vertices, normals (n, 3) where the scene draws it, faces (m, 3); albedo (3,) in linear light, or st (n, 2) and a
    picture as of `snowmpm.reading.skin.Skin`."""

    vertices: np.ndarray
    faces: np.ndarray
    normals: np.ndarray
    albedo: np.ndarray
    st: np.ndarray | None = None
    picture: np.ndarray | None = None

    @classmethod
    def of(cls, vertices, facets, longest, skin=None):
        """longest [m]: of its edges, for the light on it; skin: `snowmpm.reading.skin.Skin` of the triangles, or
        None."""
        st = np.zeros((len(vertices), 2)) if skin is None else np.asarray(skin.st, float)
        vertices, faces, st = _divided(np.asarray(vertices, float), np.asarray(facets), st, longest)
        vertices, faces, st = edged(vertices, faces, st)
        plain = skin is None or skin.picture.shape[:2] == (1, 1)
        albedo = SOLID if skin is None else light.decode(skin.picture[0, 0] / 255.0) if plain else np.ones(3)
        return cls(vertices.astype(np.float32), faces.astype(np.int32), vertex_normals(vertices, faces),
                   np.asarray(albedo, np.float32), None if plain else st, None if plain else skin.picture)

    def at(self, rotation, translation):
        """The same turned (3, 3) and moved (3,)."""
        return Solid((self.vertices @ rotation.T + translation).astype(np.float32), self.faces,
                     (self.normals @ rotation.T).astype(np.float32), self.albedo, self.st, self.picture)


class Solids:
    """Those of a run; longest [m]: of their edges."""

    def __init__(self, run, saw, longest):
        self._run, self._saw, self._longest = run, saw, longest

    @cached_property
    def _at_first(self):
        """[(`snowmpm.io.Obstacle`, `Solid`)] where the scene draws them."""
        found = []
        for one in self._run.obstacles.values():
            parts = [(skin.vertices, skin.facets, skin) for skin in one.skins] or [(one.vertices, one.facets, None)]
            found += [(one, Solid.of(vertices, facets, self._longest, skin)) for vertices, facets, skin in parts
                      if len(facets)]
        return found

    def at(self, i, near):
        """[`Solid`] of frame `i`; near: as of `View.near`."""
        found = [solid.at(one.rotation[i], one.translation[i]) for one, solid in self._at_first]
        if self._saw:
            vertices, facets = self._saw.placed(float(self._run.times[i]), near)
            found.append(Solid.of(turned(self._run, vertices), facets, self._longest))
        return found


def edged(vertices, faces, *others):
    """Vertices, faces and the others (n, ...) with vertices of their own on each side of a sharp edge."""
    mesh = trimesh.Trimesh(vertices, faces, process=False)
    smooth = mesh.face_adjacency[mesh.face_adjacency_angles < CREASE]
    side = trimesh.graph.connected_component_labels(smooth, node_count=len(faces))
    pairs, number = np.unique(np.column_stack([faces.ravel(), np.repeat(side, 3)]), axis=0, return_inverse=True)
    return vertices[pairs[:, 0]], number.reshape(-1, 3), *(other[pairs[:, 0]] for other in others)


def _divided(vertices, faces, st, longest):
    """The same with all edges at most so long [m], or MOST_FACES."""
    while len(faces) * 4 <= MOST_FACES:
        corners = vertices[faces]
        long = np.flatnonzero(np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1) > longest)
        if not len(long):
            break
        vertices, faces, more = trimesh.remesh.subdivide(vertices, faces, long, {"st": st})
        st = more["st"]
    return vertices, faces, st
