"""Points of an interface (`.column`): where they lie, and what they stand for."""

from typing import NamedTuple

import numpy as np

from snowmpm.components.interface_layer.column import COLUMN, CUT, lift_at, size
from snowmpm.components.interface_layer.declare import thickness_of
from snowmpm.particles.population import Population
from snowmpm.seeding.lattice import unit_points
from snowmpm.seeding.profile_layer import OffsetLine, stretch
from snowmpm.seeding.regions import regions_of
from snowmpm.seeding.terrain_layer import terrain_layer

SMALL = 1e-3
"""Share of the thickness over which the direction of a profile's normals is read."""


class Points(NamedTuple):
    """positions (n, dim) [m] on the upper face of the layer, volumes (n,) of the layer below them [m3], columns
    (n, size)."""

    positions: np.ndarray
    volumes: np.ndarray
    columns: np.ndarray


def seeds(scene, i, surface, material):
    """`Population` of body i of a scene on its ground, None where it is no interface; material: its index. InputError:
    a region off the terrain."""
    body, dim = scene.bodies[i], scene.dimension
    if not body.interface:
        return None
    x, volumes, columns = points_of(scene, body, surface, f"bodies.{i}.shape")
    return Population(x, volumes, material, columns={COLUMN: columns}, unstressed=columns[:, CUT * dim] > 0.0)


def points_of(scene, body, surface, key):
    """`Points` of a body of a scene; key: name of its shape in messages. InputError: a region off the terrain."""
    thickness, spacing = thickness_of(scene, body), scene.solver.dx / body.interface
    lift = 0.5 * scene.solver.spacing(scene.dimension)
    if scene.saw_test:
        return _lifted(_of_saw_test(scene.saw_test, scene.dimension, thickness, spacing), lift)
    make = _on_profile if scene.dimension == 2 else _on_terrain
    regions = regions_of(body.shape.region, surface, scene.base_dir, f"{key}.region")
    parts = [make(surface, region, thickness, spacing, scene.solver.dx) for region in regions]
    x, volumes, normals = (np.concatenate(rows) for rows in zip(*parts, strict=True))
    return _lifted(Points(x, volumes, _columns(normals, thickness)), lift)


def _lifted(points, lift):
    """Points that lie `lift` [m] above the face."""
    dim = points.positions.shape[1]
    points.columns[:, lift_at(dim)] = lift
    normals = points.columns[:, :dim] / np.linalg.norm(points.columns[:, :dim], axis=1, keepdims=True)
    return points._replace(positions=points.positions + lift * normals)


def _columns(normals, thickness):
    rows = np.zeros((len(normals), size(normals.shape[1])))
    rows[:, : normals.shape[1]] = normals / thickness
    return rows


def _of_saw_test(test, dim, thickness, spacing):
    """In the frame of the slope; under the notch they are cut."""
    extent = np.array([test.length, test.width_in(dim)][: dim - 1])
    counts = np.maximum(np.round(extent / spacing), 1).astype(int)
    plan = unit_points(counts, "regular", None) * (extent / counts)
    cut = plan[:, 0] < test.notch
    plan[:, 1:] -= 0.5 * extent[1:]
    x = np.column_stack([plan, np.full(len(plan), test.slab_bottom)])
    columns = _columns(np.tile(np.eye(dim)[-1], (len(x), 1)), thickness)
    columns[cut, CUT * dim] = 1.0
    return Points(x, np.full(len(x), extent.prod() * thickness / len(x)), columns)


def _on_profile(surface, region, thickness, spacing, dx):
    ground = stretch(surface, region)
    line, middle = OffsetLine(ground, thickness), OffsetLine(ground, 0.5 * thickness)
    n = max(round(line.length / spacing), 1)
    along, none = (np.arange(n) + 0.5) / n * line.length, np.zeros(n)
    x = line.points(along, none)
    normals = (line.points(along, none + SMALL * thickness) - x) / (SMALL * thickness)
    return x, np.full(n, middle.length * thickness / n), normals


def _on_terrain(surface, region, thickness, spacing, dx):
    """Two sheets of the same columns of snow tell the direction of each."""
    sheets = [terrain_layer(surface, region, low * thickness, (low + 1.0) * thickness, dx=dx, spacing=spacing,
                            sampling="regular", rng=None, rows=1) for low in (0.0, 0.5)]
    (middle, volumes), (top, _) = sheets
    normals = top - middle
    return top, volumes, normals / np.linalg.norm(normals, axis=1, keepdims=True)
