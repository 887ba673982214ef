"""Reading a run file: finished, still being written, or left behind by a program that was killed."""

import json
import time as clock
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import h5py
import numpy as np

from snowmpm import memory
from snowmpm.errors import InputError, did_you_mean
from snowmpm.io import layout
from snowmpm.io.obstacles import read_obstacles
from snowmpm.io.saw_test import read_saw_test
from snowmpm.io.transaction import SnapshotFile
from snowmpm.io.writer import read_hazard, read_provenance, run_file

ATTEMPTS = 50

FRAME_DATA = ("/VTKHDF/Points", "/VTKHDF/PointData", "/VTKHDF/Vertices")
"""What is read frame by frame, or never."""


@dataclass(frozen=True)
class Frame:
    """The particles at one time: points (n, 3) float32 [m] relative to the run's origin, fields by name."""

    time: float
    points: np.ndarray
    fields: dict

    def __len__(self):
        return len(self.points)


@dataclass(frozen=True)
class Terrain:
    """The ground: vertices (n, 3) [m] relative to the run's origin; facets (m, 3) triangles or (m, 2) segments."""

    vertices: np.ndarray
    facets: np.ndarray


@dataclass(frozen=True)
class Map:
    """A raster in plan: values (rows, columns), row i at y0 + i cell, column j at x0 + j cell [m, to the origin]."""

    values: np.ndarray
    x0: float
    y0: float
    cell: float
    units: str


class Run:
    """One run, from its folder or its file.

    What it shows is the state when it was opened or last `refresh`ed; frames are read from the disk when asked for.

    path, name (of its scene, or else of its folder), dimension (2 or 3), origin (3,) [m]
    complete (the run came to its end)
    times (frames,) [s];  len(run) frames;  run.frame(i) -> Frame
    field_names;  units of fields and history by name;  history: arrays by name, "time" among them
    terrain -> Terrain or None;  obstacles: `snowmpm.io.obstacles.Obstacle` by name;  maps: Map by name;  provenance
    hazard: run-out, affected area, profile along the thalweg, or {};  saw_test -> `snowmpm.io.saw_test.SawTest` or None
    summary (summary.json, or {})

    Raises InputError when there is no run there or its format is unknown.
    """

    def __init__(self, path):
        self.path = run_file(path)
        if not self.path.is_file():
            raise InputError(f"{path}: no run file here ({layout.RUN_FILE} is missing){_runs_near(path)}")
        self.refresh()

    def refresh(self):
        """Look again: frames and history rows may have come since."""
        for name in ("terrain", "obstacles", "saw_test", "maps", "provenance", "hazard", "summary"):
            self.__dict__.pop(name, None)
        self._checked = False
        """Whether the file was searched for what may not be in it: once, or a fast writer would always be ahead."""
        self._read(self._read_index)

    def _read_index(self, h5):
        root, attributes = h5["VTKHDF"], h5.attrs
        if attributes.get("format") != layout.FORMAT:
            raise InputError(f"{self.path}: not a run file of this program")
        if int(attributes["format_version"]) > layout.FORMAT_VERSION:
            version = int(attributes["format_version"])
            raise InputError(f"{self.path}: format version {version}; this program reads up to {layout.FORMAT_VERSION}")
        if not self._checked:
            _check_contents(h5, self.path)
            self._checked = True
        self.dimension = int(attributes["dimension"])
        self.origin = np.array(attributes["origin"])
        self.complete = bool(attributes["complete"])
        steps, count = root["Steps"], int(root["Steps"].attrs["NSteps"])
        self.times = steps["Values"][:count]
        self._starts = steps["PointOffsets"][:count]
        self._counts = root["NumberOfPoints"][:count]
        self.field_names = list(root["PointData"])
        self.history = {name: data[:] for name, data in h5["history"].items()}
        named = [*root["PointData"].items(), *h5["history"].items()]
        self.units = {name: data.attrs.get("units", "") for name, data in named}

    def _read(self, action):
        """`action(open file)`, repeated if a commit passed meanwhile, so that it has seen one state only."""
        for _ in range(ATTEMPTS):
            try:
                with self._snapshot() as (h5, snapshot):
                    result = action(h5)
                    if snapshot.is_current():
                        return result
            except InputError:
                raise
            except Exception as error:  # damaged bytes fail in HDF5, NumPy and JSON in a dozen ways
                failure = error
            else:
                failure = None
            if failure is not None and not self._being_written():
                reason = " ".join(str(failure).split())[:200]
                raise InputError(f"{self.path}: not a readable run file ({reason})") from failure
            clock.sleep(0.02)
        raise InputError(f"{self.path}: is being written faster than it can be read; try again later")

    @contextmanager
    def _snapshot(self):
        with SnapshotFile(self.path) as snapshot, h5py.File(snapshot, "r") as h5:
            yield h5, snapshot

    def _being_written(self):
        with SnapshotFile(self.path) as snapshot:
            return snapshot.counter is not None

    def __len__(self):
        return len(self.times)

    def n_points(self, i):
        """Number of particles in frame `i`, without reading it."""
        return int(self._counts[i])

    def frame(self, i, fields=None):
        """Frame `i` (negative from the end); only the named `fields`, by default all of them."""
        start, n = int(self._starts[i]), int(self._counts[i])
        names = self.field_names if fields is None else list(fields)
        for name in names:
            if name not in self.field_names:
                raise InputError.not_in("field", name, self.field_names, file=self.path)

        def action(h5):
            root = h5["VTKHDF"]
            rows = [root["Points"], *(root["PointData"][name] for name in names)]
            size = sum(n * data.dtype.itemsize * (data.shape[1] if data.ndim > 1 else 1) for data in rows)
            memory.require(size, f"{self.path}: frame {i}", "fewer fields need less")
            points = root["Points"][start : start + n]
            return points, {name: root["PointData"][name][start : start + n] for name in names}

        points, values = self._read(action)
        return Frame(float(self.times[i]), points, values)

    @property
    def name(self):
        return str(self.provenance.get("scene_name") or self.path.parent.name)

    @cached_property
    def terrain(self):
        return self._read(_read_terrain)

    @cached_property
    def obstacles(self):
        return self._read(read_obstacles)

    @cached_property
    def saw_test(self):
        return self._read(read_saw_test)

    @cached_property
    def maps(self):
        return self._read(lambda h5: {name: _read_map(data) for name, data in h5["maps"].items()})

    @cached_property
    def provenance(self):
        return self._read(read_provenance)

    @cached_property
    def hazard(self):
        return self._read(read_hazard)

    @cached_property
    def summary(self):
        path = self.path.with_name(layout.SUMMARY_FILE)
        try:
            return json.loads(path.read_text(encoding="utf-8")) if path.exists() else {}
        except (OSError, ValueError, RecursionError) as error:
            raise InputError(f"{path}: not readable ({error})") from None


def _runs_near(path):
    """"; did you mean FOLDER?" with a folder beside `path` that holds a run and is called about the same, or ""."""
    folder = Path(path).parent
    runs = [str(file.parent) for file in sorted(folder.glob(f"*/{layout.RUN_FILE}"))] if folder.is_dir() else []
    return did_you_mean(str(Path(path)), runs)


def _check_contents(h5, path):
    """Refuse what no run file of this program has: links to elsewhere, and tables that would fill the memory."""
    groups = [h5]
    while groups:
        group = groups.pop()
        for name in group:
            if not isinstance(group.get(name, getlink=True), h5py.HardLink):
                raise InputError(f"{path}: {group.name}/{name} is a link to elsewhere, which no run file has")
            item = group[name]
            if isinstance(item, h5py.Group):
                groups.append(item)
                continue
            if item.external or item.is_virtual:
                raise InputError(f"{path}: {item.name} lies in another file, which no run file has")
            if not item.name.startswith(FRAME_DATA):
                memory.require(item.nbytes, f"{path}: {item.name}", "it is not what this program writes")


def _read_terrain(h5):
    group = h5["terrain"]
    return Terrain(group["vertices"][:], group["facets"][:]) if "vertices" in group else None


def _read_map(data):
    x0, y0, cell = (float(data.attrs[name]) for name in ("x0", "y0", "cell"))
    return Map(data[:], x0, y0, cell, data.attrs["units"])
