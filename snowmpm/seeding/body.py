"""Particles of a body."""

from typing import NamedTuple

import numpy as np

from snowmpm import memory
from snowmpm.errors import InputError
from snowmpm.seeding.clipping import clipped
from snowmpm.seeding.lattice import SAMPLINGS, unit_points
from snowmpm.seeding.layers import layer_seeds
from snowmpm.seeding.rim import Rim
from snowmpm.seeding.shapes import shape_of


class Seeds(NamedTuple):
    """Initial particles: positions (n, dim) [m], volumes (n,) [m3] (in 2-D per metre of width), both float64; share: of
    the body's volume inside the sides of the domain."""

    positions: np.ndarray
    volumes: np.ndarray
    share: float = 1.0

    def chosen(self, keep):
        """The particles with keep (n,) true."""
        return Seeds(self.positions[keep], self.volumes[keep], self.share)


def seed_body(shape_spec, surface, *, dim, dx, particles_per_cell, sampling, rng, base_dir=".", key="shape",
              cut=None, columns=False, rim=0.0):
    """Fill a body with particles.

    shape_spec: object with `kind` and that kind's attributes
      box {min, max}, sphere {centre, radius} (a disc in 2-D), cylinder {base, axis, radius, height} (3-D), mesh {file}
      (3-D, closed), polygon {points} (2-D), prism {points, y} (3-D), voxels {file, voxel_size, phase, origin, counts},
      layer {bottom, top, region}: distances normal to the terrain [m]
    surface: TerrainSurface in the same coordinates; needed by layers only.
    dx [m], particles_per_cell: the mean spacing is dx / particles_per_cell^(1/dim).
    sampling: "regular", "jittered" (a lattice, each point moved by at most a quarter spacing) or "poisson".
    rng: numpy Generator; the same state gives the same particles.
    base_dir: folder of relative files; key: name of the shape in messages.
    cut: corners lower, upper (dim,) [m] beyond which nothing is filled, infinite without a cut.
    columns: particles are columns of snow, `particles_per_cell` of them in a cell in plan; a layer has one over another
    nowhere. rim: share of a layer's thickness down to which columns at its rims are divided (`seeding.rim`), or 0.

    The volumes add up to the body's: exactly for shapes and plan polygons, by the layer's own geometry for layers.
    InputError: bad numbers or files, a layer too thin for dx, a region off the terrain, no volume, no particles.
    """
    if sampling not in SAMPLINGS:
        raise InputError.at("solver.sampling", sampling, f"must be one of {', '.join(SAMPLINGS)}")
    spacing = dx / particles_per_cell ** (1.0 / (2 if columns else dim))
    if shape_spec.kind == "layer":
        positions, volumes = layer_seeds(
            shape_spec, surface, dx=dx, spacing=spacing, sampling=sampling, rng=rng, base_dir=base_dir, key=key,
            columns=columns, rim=Rim(rim, _walls(cut)) if rim else None
        )
        seeds = Seeds(np.ascontiguousarray(positions), np.ascontiguousarray(volumes))
        return seeds if cut is None else _within(seeds, *cut)
    shape, share = shape_of(shape_spec, dim, base_dir, key), 1.0
    if cut is not None:
        whole, shape = shape.volume, clipped(shape, shape_spec, *cut, key)
        share = shape.volume / whole
    positions, volumes = _filled(shape, spacing, sampling, rng, key)
    if columns:
        positions, volumes = _stacked(positions, volumes, shape, spacing)
    return Seeds(np.ascontiguousarray(positions), np.ascontiguousarray(volumes), share)


def _walls(cut):
    """Sides of the plan at which a cut holds the snow, as (axis, level) [m]."""
    return [] if cut is None else [(axis, float(corner[axis])) for corner in cut for axis in (0, 1)
                                   if np.isfinite(corner[axis])]


def _within(seeds, lower, upper):
    """The particles between two corners, for a layer, whose particles have individual volumes."""
    inside = ((seeds.positions >= lower) & (seeds.positions < upper)).all(axis=1)
    if inside.all():
        return seeds
    return Seeds(seeds.positions[inside], seeds.volumes[inside], seeds.volumes[inside].sum() / seeds.volumes.sum())


def _filled(shape, spacing, sampling, rng, key):
    """Points of a lattice fitted to the shape's box that lie in the shape; each has the same share of its volume."""
    counts = np.maximum(np.round(shape.size / spacing), 1)
    memory.require(memory.PER_PARTICLE[len(counts)] * shape.volume / spacing ** len(counts), f"{key}: its particles")
    points = shape.origin + (unit_points(counts, sampling, rng) * (shape.size / counts)) @ shape.axes
    if shape.contains is not None:
        points = points[shape.contains(points)]
    if len(points) == 0:
        raise InputError(f"{key}: too small for a particle at a spacing of {spacing:g} m; a finer solver.dx is needed")
    return points, np.full(len(points), shape.volume / len(points))


def _stacked(positions, volumes, shape, spacing):
    """One particle for all that stand over the same square of a lattice in plan, in their middle."""
    counts = np.maximum(np.round(np.asarray(shape.size)[:2] / spacing), 1)
    square = np.floor((positions[:, :2] - shape.origin[:2]) / (np.asarray(shape.size)[:2] / counts) + 1e-9)
    _, number = np.unique(square, axis=0, return_inverse=True)
    number = number.reshape(-1)
    volume = np.bincount(number, volumes)
    middle = [np.bincount(number, volumes * positions[:, a]) / volume for a in range(3)]
    return np.column_stack(middle), volume
