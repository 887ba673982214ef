"""Shapes of bodies: inside test, volume, and bounding box."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from snowmpm.errors import InputError
from snowmpm.reading.named_files import existing
from snowmpm.registry import SHAPES, resolved
from snowmpm.seeding.polygons import Polygons
from snowmpm.seeding.shells import Shells
from snowmpm.seeding.voxels import phase_inside, read_voxels
from snowmpm.terrain.mesh import mesh_facets
from snowmpm.terrain.surface import TerrainSurface


@dataclass(frozen=True, eq=False)
class Shape:
    """A body to be filled.

    origin (dim,) [m], axes (dim, dim) unit rows and size (dim,) [m]: a box that holds it; volume [m3] ([m2] in 2-D);
    contains: points (k, dim) -> (k,) bool, or None when the box is the body. facets (n, 3, 3): of a mesh; part: of
    polygons and voxels, (lower, upper) -> volume within a block, for what sides of the domain cut off (`clipping`).
    """

    origin: np.ndarray
    axes: np.ndarray
    size: np.ndarray
    volume: float
    contains: Any = None
    facets: np.ndarray | None = None
    part: Any = None


def shape_of(spec, dim, base_dir, key):
    """Shape of a scene's shape table, or of an object with its attributes.

    InputError: wrong number of coordinates, no volume, unreadable or open mesh.
    """
    filling = {name: shape for name, shape in SHAPES.items() if shape.FILLS}
    if spec.kind not in filling:
        raise InputError.at(f"{key}.kind", spec.kind, f"must be one of {', '.join([*filling, 'layer'])}")
    only = filling[spec.kind].DIMENSION or dim
    if only != dim:
        raise InputError.at(f"{key}.kind", spec.kind, f"exists in {only}-D scenes only")
    return resolved(filling[spec.kind].FILLS)(spec, dim, base_dir, key)


def _vector(values, dim, key):
    vector = np.asarray(values, float)
    if vector.shape != (dim,) or not np.isfinite(vector).all():
        raise InputError.at(key, np.asarray(values).tolist(), f"must be {dim} finite numbers")
    return vector


def box(spec, dim, base_dir, key):
    """A block along the axes, or a rectangle."""
    lower, upper = _vector(spec.min, dim, f"{key}.min"), _vector(spec.max, dim, f"{key}.max")
    if not (upper > lower).all():
        raise InputError.at(f"{key}.max", upper.tolist(), f"must be larger than min = {lower.tolist()} on every axis")
    return Shape(lower, np.eye(dim), upper - lower, float(np.prod(upper - lower)))


def sphere(spec, dim, base_dir, key):
    """A ball, or a disc."""
    centre, radius = _vector(spec.centre, dim, f"{key}.centre"), float(spec.radius)
    if not radius > 0:
        raise InputError.at(f"{key}.radius", radius, "must be > 0")
    volume = np.pi * radius**2 if dim == 2 else 4.0 / 3.0 * np.pi * radius**3

    def contains(points):
        return ((points - centre) ** 2).sum(axis=1) < radius**2

    return Shape(centre - radius, np.eye(dim), np.full(dim, 2.0 * radius), volume, contains)


def cylinder(spec, dim, base_dir, key):
    """A cylinder in any direction."""
    base, axis = _vector(spec.base, 3, f"{key}.base"), _vector(spec.axis, 3, f"{key}.axis")
    radius, height = float(spec.radius), float(spec.height)
    for name, value in (("radius", radius), ("height", height)):
        if not value > 0:
            raise InputError.at(f"{key}.{name}", value, "must be > 0")
    if not np.linalg.norm(axis) > 0:
        raise InputError.at(f"{key}.axis", axis.tolist(), "must not be zero")
    axis = axis / np.linalg.norm(axis)
    # The coordinate axis least along the cylinder's gives the first direction across: upright cylinders keep x and y.
    across = np.eye(3)[np.argmin(np.abs(axis))]
    u = across - (across @ axis) * axis
    u /= np.linalg.norm(u)
    axes = np.stack([u, np.cross(axis, u), axis])

    def contains(points):
        local = (points - base) @ axes[:2].T
        return (local**2).sum(axis=1) < radius**2

    origin = base - radius * (axes[0] + axes[1])
    return Shape(origin, axes, np.array([2 * radius, 2 * radius, height]), np.pi * radius**2 * height, contains)


def polygon(spec, dim, base_dir, key):
    """A polygon (2-D)."""
    area = Polygons.of([[spec.points]], f"{key}.points")
    lower, upper = area.bounds()
    return Shape(lower, np.eye(2), upper - lower, area.area(), area.contains, part=area.area_within)


def prism(spec, dim, base_dir, key):
    """A polygon in the plane of x and z, between two values of y."""
    face, (first, last) = polygon(spec, 2, base_dir, key), spec.y
    size = np.insert(face.size, 1, last - first)

    def part(lower, upper):
        along = min(last, upper[1]) - max(first, lower[1])
        return face.part(lower[[0, 2]], upper[[0, 2]]) * max(0.0, along)

    return Shape(np.insert(face.origin, 1, first), np.eye(3), size, face.volume * (last - first),
                 lambda points: face.contains(points[:, [0, 2]]), part=part)


def mesh(spec, dim, base_dir, key):
    """The inside of a closed mesh."""
    path = existing(spec.file, base_dir, f"{key}.file")
    vertices, facets = mesh_facets(path, f"{key}.file")
    surface = TerrainSurface.of(vertices, facets)
    if not surface.closed:
        raise InputError.at(f"{key}.file", str(spec.file), "must be a closed mesh (it has open edges, so no inside)")
    size, shells = surface.upper - surface.lower, Shells(vertices, facets, surface)
    volume, exact = shells.volume(f"{key}.file = {str(spec.file)!r}")
    if not volume > 1e-9 * np.prod(size):
        raise InputError.at(f"{key}.file", str(spec.file), "encloses no volume")
    return Shape(surface.lower, np.eye(3), size, volume, shells.contains, facets=shells.facets() if exact else None)


def voxels(spec, dim, base_dir, key):
    """The voxels of one value."""
    voxels = read_voxels(spec, dim, base_dir, key)
    origin = np.zeros(dim) if spec.origin is None else _vector(spec.origin, dim, f"{key}.origin")
    count = int((voxels == spec.phase).sum())
    if count == 0:
        known = ", ".join(str(value) for value in np.unique(voxels)[:8])
        raise InputError.at(f"{key}.phase", spec.phase, f"is no value of the image, which has {known}")
    size = spec.voxel_size * np.array(voxels.shape)
    contains = phase_inside(voxels, spec.phase, spec.voxel_size, origin)

    def part(lower, upper):
        of_axis = [_covered(n, low, high) for n, low, high in zip(
            voxels.shape, (lower - origin) / spec.voxel_size, (upper - origin) / spec.voxel_size, strict=True)]
        filled = (voxels == spec.phase).astype(float)
        for share in reversed(of_axis):
            filled = filled @ share
        return float(filled) * spec.voxel_size**dim

    return Shape(origin, np.eye(dim), size, count * spec.voxel_size**dim, contains, part=part)


def _covered(n, low, high):
    """Share of each of n voxels in a row, (n,), between two places [voxels]."""
    at = np.arange(n)
    return np.clip(np.minimum(high, at + 1.0) - np.maximum(low, at), 0.0, 1.0)
