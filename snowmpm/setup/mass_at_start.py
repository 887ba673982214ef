"""Whether the mass at the start is that of the bodies: density times the volume of their union, above the ground."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from snowmpm import components
from snowmpm.scenes.shapes import ThicknessRaster
from snowmpm.seeding.regions import regions_of
from snowmpm.seeding.shapes import shape_of
from snowmpm.seeding.thickness import RasterThickness
from snowmpm.setup.obstacle_reach import Doubt

LEAST = 0.01
"""Share of a volume from which on it is said to be counted twice, or to lie below the ground."""

SAMPLE = 5000
"""Particles of a body that are looked at, at most: a share of LEAST is then known within 0.15 %."""

NEAR = 0.1
"""Spacings by which a particle must lie inside another body, or below the ground, to count: round-off."""

MOST_NAMED = 3

HEIGHTS = 8
"""Places up a column of a depth-averaged flow."""


def mass_doubts(model) -> Iterator[Doubt]:
    """`Doubt`s about bodies of a `Model` that share a place, or lie below the ground."""
    bodies = [_Filled(model, i) for i, body in enumerate(model.scene.bodies)
              if not components.carried(model.scene, body)]
    if model.surface is not None:
        yield from _buried(model, bodies)
    measure = "m3" if model.scene.dimension == 3 else "m2"
    shared = []
    for one, other in _neighbours(bodies):
        volume = _shared(one, other) if one.body.start_time == other.body.start_time else 0.0
        share = volume / min(one.volume, other.volume) if volume else 0.0
        if share > LEAST:
            shared.append((share, volume, one, other))
    shared.sort(key=lambda found: -found[1])
    for share, volume, one, other in shared[:MOST_NAMED]:
        yield Doubt(f"bodies.{other.i} ({other.body.name})", f"shares {volume:.3g} {measure}, {share:.0%} of the"
                    f" smaller, with {one.body.name}: its mass counts twice there", "cut one of them, or take one away")
    if len(shared) > MOST_NAMED:
        yield Doubt("bodies", f"{len(shared) - MOST_NAMED} more pairs share a place", "as above")


class _Filled:
    """A body of a model with its particles, at most SAMPLE of them."""

    def __init__(self, model, i):
        self.model, self.i, self.body = model, i, model.scene.bodies[i]
        ends = [*model.body_starts, len(model.population.volumes)]
        own = slice(ends[i], ends[i + 1])
        positions, volumes = model.population.positions[own], model.population.volumes[own]
        self.volume = float(volumes.sum())
        self.spacing = model.scene.solver.spacing(model.scene.dimension)
        self.lower: Any = positions.min(axis=0) if len(positions) else None
        self.upper: Any = positions.max(axis=0) if len(positions) else None
        if len(positions) > SAMPLE:  # the same ones for the same scene
            chosen = np.random.default_rng(0).choice(len(positions), SAMPLE, replace=False)
            positions, volumes = positions[chosen], volumes[chosen]
        self.margin = NEAR * self.spacing
        if model.scene.solver.in_plan and len(positions):
            positions, volumes = self._along_columns(positions, volumes)
        self.positions, self.weights = positions, volumes / max(volumes.sum(), 1e-300)

    def _along_columns(self, positions, volumes):
        """Places up the columns, which stand for snow from below to above their middles."""
        depth = volumes / self.spacing**2
        self.margin = NEAR * float(np.median(depth))
        rise = np.linspace(-0.5, 0.5, 2 * HEIGHTS + 1)[1::2, None] * depth
        places = np.tile(positions, (HEIGHTS, 1))
        places[:, -1] += rise.ravel()
        self.lower, self.upper = places.min(axis=0), places.max(axis=0)
        return places, np.tile(volumes, HEIGHTS)

    def holds(self, points):
        """Whether each point (n, dim) lies in the body, as the seeding has it."""
        return (_in_layer if self.body.shape.kind == "layer" else _in_shape)(self, points)


def _in_shape(filled, points):
    scene, spec = filled.model.scene, filled.body.shape
    shape = shape_of(spec, scene.dimension, scene.base_dir, f"bodies.{filled.i}.shape")
    margin = filled.margin
    local = (points - shape.origin) @ shape.axes.T
    inside = ((local > margin) & (local < shape.size - margin)).all(axis=1)
    if shape.contains is not None and inside.any():
        inside[inside] = shape.contains(points[inside])
    return inside


def _in_layer(filled, points):
    """By the height over the plane of the ground below."""
    model, spec = filled.model, filled.body.shape
    surface, margin = model.surface, filled.margin
    plan, z = points[:, :-1], points[:, -1]
    gradient = np.nan_to_num(surface.gradient(plan, model.scene.solver.dx)).reshape(len(plan), -1)
    upright = 1.0 / np.sqrt(1.0 + (gradient**2).sum(axis=1))
    distance = np.nan_to_num(z - surface.height(plan), nan=-1.0) * upright
    foot = plan + (distance * upright)[:, None] * gradient
    key = f"bodies.{filled.i}.shape"
    inside = np.zeros(len(points), bool)
    for region in regions_of(spec.region, surface, model.scene.base_dir, f"{key}.region", spec.attribute):
        if isinstance(spec.top, ThicknessRaster):
            raster = RasterThickness.of(spec.top, model.scene.base_dir, f"{key}.top.file", surface.system)
            top = spec.bottom + raster.at(foot)
        else:
            top = spec.bottom + region.thickness if spec.top == "file" else spec.top
        within = ((foot > region.lower) & (foot < region.upper)).all(axis=1)
        within &= (distance > spec.bottom + margin) & (distance < top - margin)
        if region.polygons is not None and within.any():
            within[within] = region.polygons.contains(foot[within])
        inside |= within
    return inside


def _shared(one, other):
    """Volume [m3] that both hold, as the particles of the smaller see it."""
    small, large = sorted((one, other), key=lambda body: body.volume)
    x = small.positions
    near = ((x > large.lower - large.spacing) & (x < large.upper + large.spacing)).all(axis=1)
    return float(small.weights[near] @ large.holds(x[near])) * small.volume if near.any() else 0.0


def _neighbours(bodies):
    """Pairs of bodies whose particles' boxes overlap, by a sweep along x."""
    there = sorted((b for b in bodies if b.lower is not None), key=lambda b: b.lower[0])
    active: list[Any] = []
    for body in there:
        active = [one for one in active if one.upper[0] > body.lower[0]]
        for one in active:
            if ((one.lower < body.upper) & (body.lower < one.upper)).all():
                yield (one, body) if one.i < body.i else (body, one)
        active.append(body)


def _buried(model, bodies):
    for filled in bodies:
        if filled.body.shape.kind == "layer" or filled.lower is None:
            continue
        height = model.surface.height(filled.positions[:, :-1])
        below = filled.positions[:, -1] < height - filled.margin  # no ground: not a number, not below
        share = float(filled.weights @ below)
        if share > LEAST:
            yield Doubt(f"bodies.{filled.i} ({filled.body.name})", f"{share:.0%} of it lies below the ground, where the"
                        " ground pushes it out at once", "put it on the ground, or cut it there")
