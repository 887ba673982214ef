"""Obstacles in a run file: their shape, their pose in each frame, and the loads by the snow."""

from dataclasses import dataclass

import h5py
import numpy as np

from snowmpm.annotations import Numbers
from snowmpm.glance import ArraysGlance
from snowmpm.io.rows import as_rows
from snowmpm.io.skins import SKIN, create_skins, read_skins
from snowmpm.io.vtkhdf import COMPRESSION, append, growing
from snowmpm.reading.skin import Skin

GROUP = "obstacles"
LOADS = {"time": "s", "force": "N", "moment": "N m", "impulse": "N s", "work": "J"}
POSES = ("rotation", "translation")


@dataclass(frozen=True, repr=False)
class Obstacle(ArraysGlance):
    """An obstacle of a run.

    vertices (n, 3) [m] where the scene draws it, relative to the run's origin (`run.origin + vertices`: in the scene's
    coordinates, those of the map), whatever the centre of rotation; facets (m, 3) triangles or (m, 2)
    segments; in frame i it is at rotation[i] @ x + translation[i], (frames, 3, 3) and (frames, 3).
    Loads by the snow at the end of each interval of `time` (rows,) [s], means over the interval: force (rows, 3) [N],
    moment about the centre of rotation, (rows, 3) [N m] or, in 2-D, (rows,), positive from +x towards +z; since the
    start: impulse (rows, 3) [N s], work (rows,) [J]. In 2-D all are per metre of width.
    skins: what it looks like, a `Skin` for each material of its mesh file, where the scene draws it; mostly none.
    """

    vertices: Numbers
    facets: Numbers
    rotation: Numbers
    translation: Numbers
    time: Numbers
    force: Numbers
    moment: Numbers
    impulse: Numbers
    work: Numbers
    skins: tuple[Skin, ...] = ()

    def placed(self, frame: int) -> Numbers:
        """Vertices (n, 3) [m] in that frame."""
        return self.vertices @ self.rotation[frame].T + self.translation[frame]


def create_obstacles(h5, drawings, dimension, skins=None):
    """Groups for obstacles {name: (vertices, facets)} in a new run file; skins: {name: [`Skin`]}."""
    root = h5.create_group(GROUP)
    width = "/m" if dimension == 2 else ""
    for name, (vertices, facets) in drawings.items():
        group = root.create_group(name)
        create_skins(group, (skins or {}).get(name, ()))
        group.create_dataset("vertices", data=as_rows(vertices).astype(np.float64), **COMPRESSION).attrs["units"] = "m"
        group.create_dataset("facets", data=np.asarray(facets, np.int32), **COMPRESSION)
        for load, unit in LOADS.items():
            columns = None if load in ("time", "work") or (load == "moment" and dimension == 2) else 3
            data = growing(group, load, dtype=np.float64, columns=columns)
            data.attrs["units"] = unit + (width if load != "time" else "")
        group.create_dataset("rotation", (0, 3, 3), np.float64, maxshape=(None, 3, 3), chunks=(64, 3, 3))
        growing(group, "translation", dtype=np.float64, columns=3).attrs["units"] = "m"


def append_loads(h5, loads):
    """Add rows {name: {"time": (k,), "force": (k, 2|3), ...}}."""
    for name, rows in loads.items():
        for load, values in rows.items():
            data = h5[GROUP][name][load]
            append(data, as_rows(values) if data.ndim == 2 else values)


def append_poses(h5, poses):
    """Add the poses {name: (rotation, translation)} of a frame; an obstacle without one has its initial pose."""
    for name, group in h5.get(GROUP, {}).items():
        rotation, translation = poses.get(name, (np.eye(3), np.zeros(3)))
        append(group["rotation"], _in_space(np.asarray(rotation, float))[None])
        append(group["translation"], as_rows(translation))


def last_placed(h5, name):
    """Vertices (n, 3) [m] of an obstacle relative to the run's origin, in the last frame."""
    group = h5[GROUP][name]
    return group["vertices"][:] @ group["rotation"][-1].T + group["translation"][-1]


def _in_space(rotation):
    """(3, 3) of a rotation in the plane of x and z."""
    if rotation.shape == (3, 3):
        return rotation
    return np.array([[rotation[0, 0], 0.0, rotation[0, 1]], [0.0, 1.0, 0.0], [rotation[1, 0], 0.0, rotation[1, 1]]])


def keep_obstacles(h5, limit, frames):
    """Drop the loads later than `limit` [s], and the poses after that many frames."""
    for group in h5.get(GROUP, {}).values():
        rows = int(np.searchsorted(group["time"][:], limit, side="right"))
        for load in LOADS:
            group[load].resize(rows, axis=0)
        for pose in POSES:
            group[pose].resize(frames, axis=0)


def read_obstacles(h5: h5py.File) -> dict[str, Obstacle]:
    """`Obstacle` by name; none in files of older versions."""
    groups = h5.get(GROUP, {}).items()
    return {name: Obstacle(**{key: data[:] for key, data in group.items() if key != SKIN}, skins=read_skins(group))
            for name, group in groups}
