"""Parts of the surface of bodies on which a scene presses, pulls or holds, as points with area."""

import numpy as np

from snowmpm.components.face_loads.face import FACES
from snowmpm.components.face_loads.face_points import FacePoints
from snowmpm.components.face_loads.faces import Faces
from snowmpm.errors import InputError
from snowmpm.methods import METHODS
from snowmpm.scenes.formula import compiled
from snowmpm.scenes.space import AXES
from snowmpm.solids.shape import SolidShape

PENALTY, SOLVED_PENALTY = 10.0, 1000.0
"""Of a scene that gives none: of explicit steps, and of steps that are solved for."""

REACH = 1.0
"""Distance from a particle of the body, in diagonals of a particle's cell, beyond which its surface is bare."""

FINER = 3
"""Points along a particle's spacing, before those of a particle become one."""

ALIKE = 6
"""Digits in which normals agree."""

ROUND_OFF = 1e-6
"""Of a spacing: what lies on the border of a block is in it, what lies on a side of the domain is not free."""


def faces_of(model):
    """`Faces` of a `Model`'s forces on surfaces. Raises InputError for a surface that is empty, or
    that no particles carry."""
    faces, parts, first = [], [], 0
    for i, spec in enumerate(model.scene.forces):
        if spec.kind in FACES:
            try:
                points = _points(model, spec, f"forces.{i}")
                own = slice(first, first + len(points.size))
                faces.append(_face(model, spec, f"forces.{i}", own))
                faces[-1].refuse_infinite(points.place, model.scene.end_time)
            except InputError as error:
                raise InputError(f"{model.scene.source}: {error}") from None
            parts.append(points)
            first = own.stop
    return Faces(faces, FacePoints.joined(parts))


def penalty_of(scene, spec):
    """Penalty of a force of kind "displacement" [-]."""
    if spec.penalty is not None:
        return spec.penalty
    return SOLVED_PENALTY if METHODS[scene.solver.method].capabilities.solves else PENALTY


def _face(model, spec, key, own):
    scene, given = model.scene, {}
    if spec.kind == "displacement":
        material = list(scene.materials).index(_body(scene, spec)[1].material)
        law = model.laws[material]
        given["stiffness"] = penalty_of(scene, spec) * law.density * law.wave_speed() ** 2 / scene.solver.dx
    return FACES[spec.kind](spec, scene.dimension, scene.base_dir, key,
                            lambda text: compiled(text, scene.dimension), own, **given)


def _body(scene, spec):
    return next((i, body) for i, body in enumerate(scene.bodies) if body.name == spec.body)


def _points(model, spec, key):
    scene, dim = model.scene, model.scene.dimension
    number, body = _body(scene, spec)
    spacing = scene.solver.spacing(dim)
    shape = SolidShape.of(body.shape, dim, scene.base_dir, f"bodies.{number}.shape")
    rest, area = points_on(shape, spacing / FINER)
    chosen = _free(model, rest, ROUND_OFF * spacing)
    if spec.within is not None:
        slack = ROUND_OFF * spacing
        chosen &= ((rest >= np.asarray(spec.within.min) - slack) & (rest <= np.asarray(spec.within.max) + slack)
                   ).all(axis=1)
    if not chosen.any():
        raise InputError.at(f"{key}.{'within' if spec.within else 'body'}", "a block" if spec.within else spec.body,
                            f"holds no part of the surface of {body.name} inside the domain")
    rest, area = rest[chosen], area[chosen]
    ends = [*model.body_starts, len(model.population.volumes)]
    positions = model.population.positions[ends[number] : ends[number + 1]]
    from scipy.spatial import cKDTree  # slow to import

    distance, nearest = cKDTree(positions).query(rest)
    if (far := distance > REACH * spacing * np.sqrt(dim)).any():
        place = np.array2string(rest[far][0], precision=3)
        raise InputError.at(f"{key}.body", spec.body, f"has no particle near its surface at {place} m, where an"
                            " obstacle or the domain cuts it")
    nearest, rest, area = _merged(nearest, rest, area)
    return FacePoints.of(ends[number] + nearest, rest - positions[nearest], area, rest)


def _merged(carrier, rest, area):
    """One point in place of all with the same carrier (n,) and the same normal: their middle, and all of their area. A
    particle then gets the load of all that is nearest to it, however points and particles lie to each other."""
    size = np.linalg.norm(area, axis=1)
    alike = np.column_stack([carrier, np.round(area / size[:, None], ALIKE)])
    _, first, group = np.unique(alike, axis=0, return_index=True, return_inverse=True)
    group, whole = group.reshape(-1), np.bincount(group.reshape(-1), size)
    middle = np.stack([np.bincount(group, size * column) for column in rest.T], axis=1) / whole[:, None]
    return carrier[first], middle, whole[:, None] * (area / size[:, None])[first]


def _free(model, x, slack):
    """Which points (n, dim) lie in the domain, and not on one of its sides."""
    scene, free = model.scene, ((x >= model.lower) & (x <= model.upper)).all(axis=1)
    for name, side in (scene.domain.sides(scene.dimension) if scene.domain else {}).items():
        if side != "open":
            axis, end = AXES[scene.dimension].index(name[0]), (model.lower, model.upper)[name.endswith("max")]
            free &= np.abs(x[:, axis] - end[axis]) > slack
    return free


def points_on(shape, spacing):
    """Middles (n, dim) and areas times outward normals (n, dim) of parts of a `SolidShape`'s surface: segments no
    longer than `spacing`, triangles with two sides no longer; discs and balls are those of their drawing."""
    vertices, facets = shape.drawing()
    corners = vertices[facets]
    edges = np.sort(np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2), axis=1)[:, -2]
    parts = np.maximum(np.ceil(edges / spacing - ROUND_OFF), 1).astype(int)
    found = [_divided(corners[parts == n], n) for n in np.unique(parts)]
    middles, areas = (np.concatenate(columns) for columns in zip(*found, strict=True))
    # What has no `TerrainSurface` is convex
    outward = middles - shape.origin if shape.surface is None else shape.query(middles)[1]
    return middles, areas * np.sign(np.einsum("ni,ni->n", areas, outward))[:, None]


def _divided(corners, n):
    """Segments (k, 2, 2) cut into n parts, or triangles (k, 3, 3) into n^2."""
    dim = corners.shape[2]
    if dim == 2:
        side = corners[:, 1] - corners[:, 0]
        middles = corners[:, None, 0] + ((np.arange(n) + 0.5) / n)[None, :, None] * side[:, None]
        areas = np.repeat(np.stack([side[:, 1], -side[:, 0]], axis=1) / n, n, axis=0)
        return middles.reshape(-1, 2), areas
    first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    places = [((i + 1 / 3) / n, (j + 1 / 3) / n) for i in range(n) for j in range(n - i)]
    places += [((i + 2 / 3) / n, (j + 2 / 3) / n) for i in range(n - 1) for j in range(n - 1 - i)]
    share = np.array(places)
    middles = corners[:, None, 0] + share[None, :, :1] * first[:, None] + share[None, :, 1:] * second[:, None]
    return middles.reshape(-1, 3), np.repeat(0.5 * np.cross(first, second) / n**2, len(places), axis=0)
