"""Mass, centre and inertia of a rigid shape of one density."""

from dataclasses import dataclass

import numpy as np

from snowmpm.solids.primitives import BALL, BOX, CYLINDER


@dataclass(frozen=True, eq=False)
class MassProperties:
    """mass [kg], per metre of width in 2-D; centre (dim,) [m] of mass; inertia [kg m2] about it along the axes of
    space: (1, 1) in 2-D, (3, 3) in 3-D."""

    mass: float
    centre: np.ndarray
    inertia: np.ndarray

    @classmethod
    def of(cls, shape, density=None, mass=None):
        """Those of a `SolidShape` where it is at the start, filled evenly: of a density [kg/m3] or a mass [kg]."""
        volume, centre, inertia = _unit_density(shape)
        density = density if mass is None else mass / volume
        return cls(density * volume, centre, density * inertia)


def _unit_density(shape):
    """Volume, centre, inertia about the centre for density 1."""
    half = shape.size
    if shape.surface is not None:
        return _of_polygon(shape.surface) if shape.dim == 2 else _of_mesh(shape.surface)
    if shape.dim == 2:
        if shape.kind == BALL:
            volume = np.pi * half[0] ** 2
            return volume, shape.origin, np.array([[0.5 * volume * half[0] ** 2]])
        volume = 4.0 * half[0] * half[1]
        return volume, shape.origin, np.array([[volume * (half @ half) / 3.0]])
    squares = half**2
    if shape.kind == BOX:
        volume = 8.0 * np.prod(half)
        own = volume * (squares.sum() - squares) / 3.0
    elif shape.kind == CYLINDER:
        volume = 2.0 * np.pi * squares[0] * half[2]
        across = volume * (0.25 * squares[0] + squares[2] / 3.0)
        own = np.array([across, across, 0.5 * volume * squares[0]])
    else:
        volume = 4.0 / 3.0 * np.pi * half[0] ** 3
        own = np.full(3, 0.4 * volume * squares[0])
    return volume, shape.origin, shape.axes.T @ np.diag(own) @ shape.axes


def _of_polygon(surface):
    """Sums over triangles from a corner to each side, of either orientation."""
    origin = surface.vertices[0]
    a, b = (surface.vertices[surface.facets[:, k]] - origin for k in (0, 1))
    area = 0.5 * (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])
    area *= np.sign(area.sum())
    centre = (area[:, None] * (a + b)).sum(axis=0) / (3.0 * area.sum())
    about_origin = (area * ((a**2).sum(axis=1) + (a * b).sum(axis=1) + (b**2).sum(axis=1))).sum() / 6.0
    return area.sum(), origin + centre, np.array([[about_origin - area.sum() * (centre @ centre)]])


def _of_mesh(surface):
    import trimesh  # slow to import, and few scenes have meshes that move freely

    middle = 0.5 * (surface.lower + surface.upper)
    mesh = trimesh.Trimesh(surface.vertices - middle, surface.facets, process=False)
    found = mesh.mass_properties
    sign = np.sign(found["volume"])
    return sign * found["volume"], middle + found["center_mass"], sign * found["inertia"]
