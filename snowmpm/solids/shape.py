"""Rigid shapes: signed distance and outward normal."""

import functools
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from snowmpm.compiler import runtime, ti
from snowmpm.compiler.launch import taichi_kernel
from snowmpm.errors import InputError
from snowmpm.reading.named_files import existing
from snowmpm.registry import OBSTACLES, resolved
from snowmpm.seeding.polygons import simple_outline
from snowmpm.seeding.shapes import shape_of
from snowmpm.solids.primitives import BALL, BOX, CYLINDER, SAMPLED, primitive_distance
from snowmpm.solids.samples import DistanceSamples
from snowmpm.terrain import DistanceField, TerrainSurface
from snowmpm.terrain.mesh import mesh_facets

CHORDS = 96
"""Number of sides of the polygon that represents a disc or a cylinder in drawings."""

FEW = 2000
"""Points below which one thread finds their distances sooner than several begin."""


@dataclass(frozen=True, eq=False)
class SolidShape:
    """A rigid shape at its initial position.

    kind: BOX, BALL, CYLINDER or SAMPLED (`primitives`); origin (dim,) [m]: middle of its own frame; axes (dim, dim):
    unit rows, directions of that frame; size (dim,) [m]: half sides of a box along them that holds it, and the measures
    that `primitive_distance` wants; surface: `TerrainSurface` of a polygon or mesh, else None, and reach [m], how far
    from it distances are exact (at most as far as it is large); file: the mesh file, else None.
    """

    kind: int
    origin: np.ndarray
    axes: np.ndarray
    size: np.ndarray
    surface: Any = None
    reach: float = np.inf
    file: Any = None

    @classmethod
    def of(cls, spec, dim, base_dir=".", key="shape", reach=np.inf, ground=None):
        """Shape of a scene's shape table: box, sphere, cylinder (3-D), mesh (3-D), polygon (2-D) or footprint (3-D).

        reach [m]: beyond it the distance from a mesh may be truncated; for many triangles a small reach is much faster.
        ground: `TerrainSurface` on which it stands, for those that need one. InputError: a mesh that is open or cannot
        be read, a polygon that crosses itself, no volume.
        """
        kind = OBSTACLES[spec.kind]
        more = (ground,) if kind.ON_GROUND else ()
        return replace(resolved(kind.SOLID)(spec, dim, base_dir, key, *more), reach=reach)

    def lifted(self, height):
        """The same shape, higher by `height` [m]."""
        up = np.array([*[0.0] * (self.dim - 1), height])
        return replace(self, origin=self.origin + up,
                       surface=None if self.surface is None else self.surface.recentred(-up))

    def put_down(self, ground, key):
        """The same shape with its lowest point at the lowest ground under it, of a `TerrainSurface`. InputError: there
        is none."""
        vertices, facets = self.drawing()
        places = np.concatenate([vertices, vertices[facets].mean(axis=1)])
        below = ground.height(places[:, :-1])
        if np.isnan(below).all():
            raise InputError(f"{key}: has no ground under it to stand on")
        return self.lifted(float(np.nanmin(below)) - float(vertices[:, -1].min()))

    @property
    def dim(self):
        return len(self.origin)

    def query(self, points):
        """Signed distance (k,) [m], > 0 outside, and outward unit normals (k, dim) at points (k, dim) [m].

        Exact; that of a polygon or mesh within `reach`, +-reach beyond.
        """
        points = np.ascontiguousarray(np.asarray(points, np.float64).reshape(-1, self.dim))
        if self.surface is not None:
            return self._field.query(points)
        local = np.ascontiguousarray((points - self.origin) @ self.axes.T)
        distance, normal = np.empty(len(points)), np.empty_like(points)
        if len(points):
            runtime.start()
            with runtime.precision("f64"):
                distances = _primitive_distances(self.dim, len(points) < FEW)
                distances(self.kind, local, *_three(self.size), distance, normal)
        return distance, normal @ self.axes

    @cached_property
    def _field(self):
        return DistanceField(self.surface, self.reach)

    def samples(self, spacing, reach, name="obstacle"):
        """`DistanceSamples` in the shape's own frame, for a polygon or mesh."""
        field = DistanceField(self.surface, reach)
        return DistanceSamples.of(lambda local: field.query(self.origin + local), -self.size, self.size, spacing,
                                  field.reach, name)

    def drawing(self):
        """Vertices (n, dim) [m] and facets that draw it: (m, 3) triangles, or (m, 2) segments, one after the other."""
        if self.surface is not None:
            return self.surface.vertices, self.surface.facets
        if self.dim == 2:
            ring = _square() if self.kind == BOX else _circle()
            number = np.arange(len(ring))
            return self.origin + (ring * self.size) @ self.axes, np.column_stack([number, np.roll(number, -1)])
        import trimesh  # slow to import, and needed only for drawing

        mesh = {BOX: lambda: trimesh.creation.box(extents=[2.0] * 3),
                BALL: lambda: trimesh.creation.icosphere(subdivisions=4, radius=1.0),
                CYLINDER: lambda: trimesh.creation.cylinder(radius=1.0, height=2.0, sections=CHORDS)}[self.kind]()
        return self.origin + (np.asarray(mesh.vertices) * self.size) @ self.axes, np.asarray(mesh.faces)


    def skins(self):
        """[`Skin`] of a mesh file with colours, where the shape is; none of others."""
        if self.file is None:
            return []
        from snowmpm.solids.skin import skins_of

        found = skins_of(self.file)
        if not found:
            return []
        low = np.min([skin.vertices.min(axis=0) for skin in found], axis=0)
        return [replace(skin, vertices=skin.vertices + (self.surface.lower - low)) for skin in found]


def _square():
    return np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])


def _circle():
    angle = 2.0 * np.pi * np.arange(CHORDS) / CHORDS
    return np.column_stack([np.cos(angle), np.sin(angle)])


def _three(size):
    return [*map(float, size), *[0.0] * (3 - len(size))]


def _primitive(kind):
    def build(spec, dim, base_dir, key):
        box = shape_of(spec, dim, base_dir, key)
        return SolidShape(kind, box.origin + 0.5 * box.size @ box.axes, box.axes, 0.5 * box.size)
    return build


def polygon(spec, dim, base_dir, key):
    """Rigid polygon (2-D)."""
    points = simple_outline(spec.points, f"{key}.points")
    number = np.arange(len(points))
    return _of_surface(points, np.column_stack([number, np.roll(number, -1)]), f"{key}.points: the polygon")


def mesh(spec, dim, base_dir, key):
    """Rigid closed mesh."""
    path = existing(spec.file, base_dir, f"{key}.file")
    made = _of_surface(*mesh_facets(path, f"{key}.file"), f"{key}.file = {str(spec.file)!r}: the mesh")
    return replace(made, file=path)


def _of_surface(vertices, facets, what):
    try:
        surface = TerrainSurface.of(vertices, facets)
    except InputError:
        raise InputError(f"{what} has no sides with a size") from None
    size = surface.upper - surface.lower
    if not surface.closed:
        raise InputError(f"{what} must be closed (it has open edges, so no inside)")
    if not surface.volume() > 1e-9 * np.prod(size):
        raise InputError(f"{what} encloses nothing")
    dim = len(size)
    return SolidShape(SAMPLED, 0.5 * (surface.lower + surface.upper), np.eye(dim), 0.5 * size, surface)


box, sphere, cylinder = _primitive(BOX), _primitive(BALL), _primitive(CYLINDER)


@functools.cache
def _primitive_distances(dim, few):
    @taichi_kernel
    def distances(kind: int, points: ti.types.ndarray(), first: ti.f64, second: ti.f64, third: ti.f64,
                  distance: ti.types.ndarray(), normal: ti.types.ndarray()):
        ti.loop_config(serialize=ti.static(few))
        for i in range(points.shape[0]):
            x, size = ti.Vector([points[i, k] for k in ti.static(range(dim))]), ti.Vector([first, second, third])
            d, n = primitive_distance(dim, kind, x, size)
            distance[i] = d
            for k in ti.static(range(dim)):
                normal[i, k] = n[k]

    return distances
