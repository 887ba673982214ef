"""Points of an interface (`particles.interface`): where they lie, and what they stand for."""

from typing import NamedTuple

import numpy as np

from snowmpm.particles.interface import CUT, interface_size, lift_at
from snowmpm.seeding.lattice import unit_points
from snowmpm.seeding.profile_layer import OffsetLine, stretch
from snowmpm.seeding.regions import regions_of
from snowmpm.seeding.terrain_layer import terrain_layer

SMALL = 1e-3
"""Share of the thickness over which the direction of a profile's normals is read."""


class Points(NamedTuple):
    """positions (n, dim) [m] on the upper face of the layer, volumes (n,) of the layer below them [m3], columns
    (n, interface_size)."""

    positions: np.ndarray
    volumes: np.ndarray
    columns: np.ndarray


def thickness_of(scene, body):
    """Thickness [m] of a body that is an interface."""
    return scene.saw_test.weak_layer.thickness if scene.saw_test else body.shape.top


def interface_points(scene, body, surface, key):
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
    rows = np.zeros((len(normals), interface_size(normals.shape[1])))
    rows[:, : normals.shape[1]] = normals / thickness
    return rows


def _of_saw_test(test, dim, thickness, spacing):
    """In the frame of the slope; under the notch they are cut."""
    size = np.array([test.length, test.width_in(dim)][: dim - 1])
    counts = np.maximum(np.round(size / spacing), 1).astype(int)
    plan = unit_points(counts, "regular", None) * (size / counts)
    cut = plan[:, 0] < test.notch
    plan[:, 1:] -= 0.5 * size[1:]
    x = np.column_stack([plan, np.full(len(plan), test.slab_bottom)])
    columns = _columns(np.tile(np.eye(dim)[-1], (len(x), 1)), thickness)
    columns[cut, CUT * dim] = 1.0
    return Points(x, np.full(len(x), size.prod() * thickness / len(x)), columns)


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
                            sampling="regular", rng=None, columns=True) for low in (0.0, 0.5)]
    (middle, volumes), (top, _) = sheets
    normals = top - middle
    return top, volumes, normals / np.linalg.norm(normals, axis=1, keepdims=True)
