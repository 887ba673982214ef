"""Bodies with forces on their surface, outside any scene: lattices turned by an angle, faces made by hand."""

import numpy as np
from scipy.spatial import cKDTree

from snowmpm.components.face_loads import declare
from snowmpm.components.face_loads.face import FACES
from snowmpm.components.face_loads.face_points import FacePoints
from snowmpm.components.face_loads.faces import Faces
from snowmpm.components.face_loads.implicit import FaceLoads
from snowmpm.scenes.formula import compiled
from snowmpm.stepping.component import Adapters

SPECS = {"traction": declare.Traction, "follower_pressure": declare.FollowerPressure,
         "displacement": declare.Displacement}


def turned(angle):
    """Rotation in the plane by `angle` [degrees], rows are the axes of the turned frame."""
    c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    return np.array([[c, s], [-s, c]])


def block(counts, spacing, axes, corner):
    """Positions and volumes of a lattice of `counts` particles along the axes (dim, dim) from a corner (dim,) [m]."""
    grid = np.stack(np.meshgrid(*(np.arange(n) + 0.5 for n in counts), indexing="ij"), axis=-1)
    x = corner + spacing * grid.reshape(-1, len(counts)) @ axes
    return x, np.full(len(x), spacing ** len(counts))


def end(counts, spacing, axes, corner, axis, upper):
    """Places and areas times normals of one face of such a block, a point over each particle."""
    others = [np.arange(n) + 0.5 if a != axis else np.array([float(counts[axis]) * upper])
              for a, n in enumerate(counts)]
    rest = corner + spacing * np.stack(np.meshgrid(*others, indexing="ij"), axis=-1).reshape(-1, len(counts)) @ axes
    return rest, np.broadcast_to(spacing ** (len(counts) - 1) * (1.0 if upper else -1.0) * axes[axis], rest.shape)


def faces(positions, given, stiffness=0.0):
    """`Faces` of [(kind, rest, area, keys of the force)] on particles at `positions`; stiffness: k [N/m3] of
    displacements."""
    dim, made, parts, first = positions.shape[1], [], [], 0
    for i, (kind, rest, area, keys) in enumerate(given):
        nearest = cKDTree(positions).query(rest)[1]
        spec = SPECS[kind].model_validate({"kind": kind, "name": f"face_{i}", "body": "one", **keys})
        more = {"stiffness": stiffness} if kind == "displacement" else {}
        made.append(FACES[kind](spec, dim, ".", f"forces.{i}", lambda text: compiled(text, dim),
                                slice(first, first + len(rest)), **more))
        parts.append(FacePoints.of(nearest, rest - positions[nearest], np.array(area), rest))
        first += len(rest)
    return Faces(made, FacePoints.joined(parts))


def load(solver, given):
    """Let `Faces` act on an `ImplicitSolver` from now on."""
    solver.adapters = Adapters([*solver.adapters, FaceLoads(given)])


def faces_on(solver):
    """`Faces` that act on a solver."""
    return solver.adapters["face_loads"].faces
