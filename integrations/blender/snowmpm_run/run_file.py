"""Reading a run folder of snowmpm with h5py and numpy, without Blender and without snowmpm."""

import json
from dataclasses import dataclass, field
from pathlib import Path

import h5py
import numpy as np

MOVING = 0.5
"""Speed [m/s] from which a particle counts as set in motion."""

LOOSE = 90
"""Particles in three cells of two spacings each way around one below which it is loose, as in `render/crumble.py`."""

MOST = 50_000_000
"""Particles of a frame that are read at most: some 3 GB."""


@dataclass
class Snow:
    """Particles of a frame: points (n, 3) [m] from the run's origin; attributes (n,) or (n, 3) by name."""

    points: np.ndarray
    attributes: dict


@dataclass
class Solid:
    """An obstacle: vertices (n, 3) [m], facets (m, 3), and its pose in each frame; skins: vertices, facets, places
    (n, 2) on a picture and the picture (rows, columns, 3) of each of its materials."""

    vertices: np.ndarray
    facets: np.ndarray
    rotation: np.ndarray
    translation: np.ndarray
    skins: list = field(default_factory=list)

    @property
    def moves(self):
        return bool(np.any(self.rotation != np.eye(3)) or np.any(self.translation != 0.0))


@dataclass
class RunFile:
    """A run in three dimensions: times (k,) [s], spacing [m] between its particles, ground (vertices, facets) or None.

    Raises ValueError where the folder holds no such run.
    """

    folder: str
    times: np.ndarray = field(init=False)

    def __post_init__(self):
        path = Path(self.folder)
        self.path = path / "run.vtkhdf" if path.is_dir() else path
        if not self.path.is_file():
            raise ValueError(f"{self.folder}: holds no run.vtkhdf")
        with self._open() as h5:
            try:
                self.dimension, self.origin = int(h5.attrs["dimension"]), np.array(h5.attrs["origin"], float)
                # Files of the first format hold places from the origin, later ones those of the map
                self._shift = self.origin if int(h5.attrs["format_version"]) > 1 else np.zeros(3)
                steps = h5["VTKHDF/Steps"]
                self.times, self._first = steps["Values"][:], steps["PointOffsets"][:]
                self._counts = h5["VTKHDF/NumberOfPoints"][:]
                self._field_first = {name: data[:] for name, data in steps["PointDataOffsets"].items()}
                self.fields = list(h5["VTKHDF/PointData"])
                record = json.loads(h5["provenance/record"][()])
            except (KeyError, ValueError, TypeError) as error:
                raise ValueError(f"{self.path}: is not a run of snowmpm ({error})") from None
            if self.dimension != 3:
                raise ValueError(f"{self.path}: a section; the add-on opens runs in three dimensions")
            ground = h5.get("terrain", {})
            self.ground = (ground["vertices"][:], ground["facets"][:]) if "vertices" in ground else None
            self.solids = {name: Solid(*(one[key][:] for key in ("vertices", "facets", "rotation", "translation")),
                                       [[part[key][:] for key in ("vertices", "facets", "st", "picture")]
                                        for part in one.get("skin", {}).values()])
                           for name, one in h5.get("obstacles", {}).items()}
        if not len(self.times) or not self._counts.any():
            raise ValueError(f"{self.path}: no frame with particles yet")
        self.name = record.get("scene_name") or self.path.resolve().parent.name
        self.spacing = float(record.get("particle_spacing") or self._neighbours())
        self._moved = None

    def _open(self):
        return h5py.File(self.path, "r", locking=False)

    def _read(self, h5, name, i):
        n = min(int(self._counts[i]), MOST)
        if name is None:
            first = int(self._first[i])
            return (h5["VTKHDF/Points"][first : first + n] - self._shift).astype(np.float32)
        first = int(self._field_first[name][i])
        return h5["VTKHDF/PointData"][name][first : first + n]

    def _neighbours(self):
        """Side [m] of the cube of one particle, by the box around the first frame that has any."""
        i = int(np.argmax(self._counts > 0))
        with self._open() as h5:
            points = self._read(h5, None, i)
        return float((np.prod(np.maximum(np.ptp(points, axis=0), 1e-3)) / len(points)) ** (1.0 / 3.0))

    def frame_at(self, time):
        """Number of the last frame at or before a time [s]; the first before all."""
        return int(np.clip(np.searchsorted(self.times, time + 1e-9, side="right") - 1, 0, len(self.times) - 1))

    def snow(self, i, time=None):
        """`Snow` of frame `i`; time [s] since then is bridged with its velocities, so that it moves between frames.

        speed [m/s], velocity [m/s], density [kg/m3] and further fields that were recorded; age [s] since a particle was
        set in motion, where its number was recorded; loose: 1 where few others surround it.
        """
        with self._open() as h5:
            points = self._read(h5, None, i)
            values = {name: self._read(h5, name, i) for name in self.fields}
        good = np.isfinite(points).all(axis=1)
        points, values = points[good], {name: value[good] for name, value in values.items()}
        found = {name: value.astype(np.int32 if value.dtype.kind in "iu" else np.float32)
                 for name, value in values.items() if value.ndim == 1 or value.shape[1] == 3}
        if "id" in values:
            moved = self._first_motion()
            at = np.minimum(values["id"], len(moved) - 1)
            found["age"] = np.maximum(self.times[i] - moved[at], 0.0).astype(np.float32)
            order = np.argsort(values["id"], kind="stable")
            points, found = points[order], {name: value[order] for name, value in found.items()}
        if "velocity" in found:
            found["speed"] = np.linalg.norm(found["velocity"], axis=1).astype(np.float32)
            if time is not None:
                # No farther than the next frame, where the next velocities take over
                later = self.times[i + 1] if i + 1 < len(self.times) else self.times[i]
                points = points + np.float32(np.clip(time, self.times[i], later) - self.times[i]) * found["velocity"]
        if "depth" in found:
            return self._piled(points, found)
        found["loose"] = loose(points, self.spacing).astype(np.float32)
        return Snow(points, found)

    def _piled(self, points, found):
        """Columns of a depth-averaged flow as piles of points from the ground to their surface."""
        depth = np.nan_to_num(found["depth"])
        layers = 1 + np.ceil(depth / self.spacing).astype(int)
        number = np.repeat(np.arange(len(points)), layers)
        step = np.arange(len(number)) - np.repeat(np.cumsum(layers) - layers, layers)
        share = step / np.maximum(layers[number] - 1, 1) - 0.5
        points = points[number] + np.column_stack([np.zeros((len(number), 2)), share * depth[number]])
        found = {name: value[number] for name, value in found.items()}
        found["loose"] = np.zeros(len(number), np.float32)
        return Snow(points.astype(np.float32), found)

    def _first_motion(self):
        """Time [s] at which the particle of each number was first faster than MOVING, inf: never."""
        if self._moved is None:
            with self._open() as h5:
                numbers = max(int(self._read(h5, "id", i).max(initial=0)) for i in range(len(self.times)))
                if numbers > MOST:
                    raise ValueError(f"{self.path}: particle number {numbers}; at most {MOST} are read")
                self._moved = np.full(numbers + 1, np.inf)
                for i in range(len(self.times)) if "velocity" in self.fields else ():
                    number = self._read(h5, "id", i)
                    fast = np.linalg.norm(self._read(h5, "velocity", i), axis=1) > MOVING
                    self._moved[number[fast]] = np.minimum(self._moved[number[fast]], self.times[i])
        return self._moved

    def action(self):
        """Places (n, 3) [m] of some particles that move, over all frames; all where none does."""
        rng, moving, resting = np.random.default_rng(0), [], []
        with self._open() as h5:
            for i in np.unique(np.linspace(0, len(self.times) - 1, 16).round().astype(int)):
                points = self._read(h5, None, i)
                if not len(points):
                    continue
                some = rng.permutation(len(points))[:3000]
                resting.append(points[some])
                if "velocity" in self.fields:
                    speed = np.linalg.norm(self._read(h5, "velocity", i)[some], axis=1)
                    moving.append(points[some][speed > MOVING])
        found = np.concatenate(moving) if moving and sum(map(len, moving)) > 100 else np.concatenate(resting)
        return found[np.isfinite(found).all(axis=1)].astype(float)


def loose(points, spacing):
    """Which particles (n,) have fewer than LOOSE in the cube of three cells, each two spacings wide, around them."""
    if not len(points):
        return np.zeros(0, bool)
    cell = np.floor((points - points.min(axis=0)) / (2.0 * spacing)).astype(np.int64).clip(0, 1 << 20)
    strides = np.array([1 << 42, 1 << 21, 1], np.int64)
    keys, place, counts = np.unique(cell @ strides, return_inverse=True, return_counts=True)
    total = np.zeros(len(keys), np.int64)
    for step in np.stack(np.meshgrid(*[(-1, 0, 1)] * 3), axis=-1).reshape(-1, 3):
        there = keys + step @ strides
        at = np.searchsorted(keys, there).clip(0, len(keys) - 1)
        total += np.where(keys[at] == there, counts[at], 0)
    return (total < LOOSE)[place.ravel()]
