"""Writing a run file, one whole frame at a time. The layout is in `snowmpm.io.layout`."""

import io
import json
import os
import shutil
import time as clock
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from snowmpm import overwriting
from snowmpm.annotations import PathLike
from snowmpm.io import layout
from snowmpm.io.archive import create_new, part_of, write_bytes
from snowmpm.io.contents import check_contents
from snowmpm.io.journal import Journal
from snowmpm.io.obstacles import append_loads, append_poses, create_obstacles, keep_obstacles
from snowmpm.io.records import HAZARD, PROVENANCE, Record, read_record
from snowmpm.io.rows import as_field, as_rows
from snowmpm.io.saw_test import append_saw_test, create_saw_test, keep_saw_test
from snowmpm.io.series import append_series, keep_series
from snowmpm.io.surroundings import GROUP as SURROUNDINGS
from snowmpm.io.surroundings import (
    append_surroundings,
    companion,
    create_surroundings,
    keep_surroundings,
    write_companion,
)
from snowmpm.io.transaction import TransactionFile
from snowmpm.io.vtkhdf import COMPRESSION, append_steps, create_steps, growing, keep_steps

HISTORY_INTERVAL = 5.0  # s of wall time: history rows wait no longer than this for the disk
WAITING_BYTES = 3.2e7  # frames that hold more do not wait for others


class RunWriter:
    """Writer of one run file; frames, history rows and maps appear whole or not at all.

    path        the file, or the folder that gets `run.vtkhdf`; an existing run there is replaced
    provenance  anything JSON can hold: resolved scene, versions, backend, precision, seed ...
    terrain     (vertices (n, 2|3) [m], facets (m, 3) triangles or (m, 2) segments), relative to `origin`; or None
    obstacles   {name: (vertices (n, 2|3) [m], facets as of the terrain)}, where the scene draws them; or None
    origin      map coordinates (x, y, z) [m] of the local origin; (x, z) in 2-D
    dimension   2 or 3
    units       unit of each field of the frames, by name
    saw_test    arguments of `io.saw_test.create_saw_test` by name, of a run that is one; or None
    skins       {name: `Skin`s} of obstacles with colours; or None
    durable     survive a power cut too, not only the death of the program (waits for the disk at each frame)
    patience    s of wall time that frames wait for others, to be written in one go: opening the file and its data sets
                takes as long as compressing 1e5 particles

    Raises InputError when another program is writing the same run; OSError when the disk is full, with every earlier
    frame readable.
    """

    def __init__(self, path, *, provenance, terrain=None, obstacles=None, origin=None, dimension=3, units=None,
                 saw_test=None, durable=True, patience=0.0, skins=None):
        self.path = run_file(path)
        self.path.parent.mkdir(parents=True, exist_ok=True)
        self._units = dict(units or {})
        self._journal = Journal(self.path, durable)
        self._file = None
        try:
            # Built in memory and moved into place: readers never see a run file without its frame structure, and HDF5
            # need not close a file on a disk that is full.
            draft, origin = io.BytesIO(), as_rows(np.zeros(dimension) if origin is None else origin)[0]
            with h5py.File(draft, "w", libver=layout.HDF5_VERSIONS) as h5:
                _create(h5, dimension, origin, self._units)
                _write_terrain(h5, terrain)
                create_obstacles(h5, obstacles or {}, dimension, skins)
                blocks = list(create_surroundings(h5, terrain, obstacles, origin))
                if saw_test:
                    create_saw_test(h5, **saw_test)
                _write_provenance(h5, provenance)
            write_bytes(self.path, draft.getbuffer())
            overwriting.note_changing(self.path)
            write_companion(self.path, blocks)
            self._open(dimension, layout.FORMAT_VERSION, origin, patience)
        except BaseException:
            self._journal.close()
            raise

    @classmethod
    def reopen(cls, path, *, until=None, durable=True, patience=0.0):
        """Continue the run file `path`; with `until` [s], first drop every frame and history row later than that."""
        self = cls.__new__(cls)
        self.path = run_file(path)
        self._journal = Journal(self.path, durable)
        self._file = None
        try:
            _unshare(self.path)
            with h5py.File(self.path, "r", locking=False) as h5:
                check_contents(h5, self.path)
                dimension, version = int(h5.attrs["dimension"]), int(h5.attrs["format_version"])
                self._units, origin = json.loads(h5.attrs["field_units"]), np.array(h5.attrs["origin"])
                blocks = list(h5.get(SURROUNDINGS, ()))
            if version > 1 and not companion(self.path).exists():
                write_companion(self.path, blocks)
            self._open(dimension, version, origin, patience)
            with self._transaction() as h5:
                h5.attrs["complete"] = False
                if until is not None:
                    _drop_after(h5, until)
        except BaseException:
            self._journal.close()
            raise
        return self

    def _open(self, dimension, version, origin, patience):
        self.dimension, self._patience = dimension, patience
        self._version, self._origin = version, origin
        self._file = TransactionFile(self.path, self._journal)
        self._frames, self._waiting, self._rows = [], 0, []
        self._row_units = {}
        self._last_commit = clock.monotonic()

    @contextmanager
    def _transaction(self):
        """Context: an open HDF5 file whose changes are committed if the block succeeds, and discarded otherwise. What
        has waited is written first."""
        self._file.begin()
        try:
            with h5py.File(self._file, "r+", libver=layout.HDF5_VERSIONS) as h5:
                self._write_frames(h5)
                self._write_rows(h5)
                yield h5
        except BaseException:
            self._file.abort()
            raise
        self._file.commit()
        self._frames.clear()
        self._rows.clear()
        self._waiting, self._last_commit = 0, clock.monotonic()

    def flush(self):
        """Write what has waited."""
        if self._frames or self._rows:
            with self._transaction():
                pass

    def frame(self, time, points, fields, poses=None, loads=None, saw_test=None, series=None):
        """Append the state at `time` [s].

        points  (n, 3) [m] relative to `origin`, or (n, 2) as (x, z), taken as float32; stored in map coordinates, as
                float64. n may change between frames.
        fields  by name, the same names in every frame: (n,), (n, 2|3) vectors or (n, 6) symmetric tensors; floats are
                stored as float32, integers as they are.
        poses   {name: (rotation (dim, dim), translation (dim,) [m])} of the obstacles that have moved, relative to
                `origin`
        loads   on obstacles since the last frame, {name: {"time" (k,), "force" (k, dim), ...}} (`io.obstacles`)
        saw_test  its rows since the last frame, and its bins (`io.saw_test`)
        series  what components recorded since the last frame (`io.series.append_series`)
        Raises ValueError for a wrong shape or another set of names.
        """
        points = as_rows(points).astype(np.float32, copy=False)
        fields = {name: as_field(name, values, len(points)) for name, values in fields.items()}
        if self._version > 1:
            points = points + self._origin
        self._frames.append((float(time), points, fields, poses or {}, loads or {}, saw_test, series or {}))
        self._waiting += points.nbytes + sum(values.nbytes for values in fields.values())
        if clock.monotonic() - self._last_commit >= self._patience or self._waiting > WAITING_BYTES:
            try:
                self.flush()
            except BaseException:
                self._frames.pop()
                raise

    def _write_frames(self, h5):
        if not self._frames:
            return
        append_steps(h5["VTKHDF"], [frame[:3] for frame in self._frames], self._units)
        for _, _, _, poses, loads, saw_test, series in self._frames:
            append_poses(h5, poses)
            append_loads(h5, loads)
            append_series(h5, series)
            append_surroundings(h5, self._origin)
            if saw_test:
                append_saw_test(h5, *saw_test)

    def history(self, time, values, units=None):
        """Append one row of the time series at `time` [s]; `units` by name, given once. Rows reach the file with the
        next frame, or after a few seconds."""
        self._row_units.update(units or {})
        self._rows.append({"time": float(time), **{name: float(value) for name, value in values.items()}})
        if clock.monotonic() - self._last_commit > HISTORY_INTERVAL:
            self.flush()

    def _write_rows(self, h5):
        """Write the waiting rows. A value missing from a row is NaN, also for rows before a name first appears."""
        if not self._rows:
            return
        group = h5["history"]
        start = len(group["time"])
        names = dict.fromkeys([*group, *(name for row in self._rows for name in row)])
        for name in names:
            if name not in group:
                growing(group, name, dtype=np.float64, fillvalue=np.nan).resize((start,))
            data = group[name]
            if name in self._row_units and "units" not in data.attrs:
                data.attrs["units"] = self._row_units[name]
            data.resize((start + len(self._rows),))
            data[start:] = [row.get(name, np.nan) for row in self._rows]

    def map(self, name, values, x0, y0, cell, units):
        """Store, or replace, a raster in plan: peak depth, peak speed ...

        values  (rows, columns), row i at y0 + i cell and column j at x0 + j cell; NaN for no data
        x0, y0  centre of the first cell [m], relative to `origin`;  cell  its side [m]
        """
        values = np.asarray(values, np.float32)
        if values.ndim != 2:
            raise ValueError(f"map {name}: shape {values.shape}, must be (rows, columns)")
        with self._transaction() as h5:
            maps = h5["maps"]
            if name in maps and maps[name].shape != values.shape:
                del maps[name]
            data = maps.require_dataset(name, values.shape, np.float32)
            data[:] = values
            data.attrs.update(x0=float(x0), y0=float(y0), cell=float(cell), units=units)

    def provenance(self, record):
        """Add to the provenance (wall time, reason of the end ...); equal names are replaced."""
        with self._transaction() as h5:
            _write_provenance(h5, {**read_provenance(h5), **record})

    def hazard(self, record):
        """Store, or replace, the hazard record: anything JSON can hold."""
        with self._transaction() as h5:
            _write_record(h5.require_group("hazard"), record)

    def close(self, complete=True):
        """Write the waiting rows and remove the journal. `complete`: the run reached its end."""
        if self._file is None:
            return
        try:
            with self._transaction() as h5:
                h5.attrs["complete"] = bool(complete)
        finally:
            self._file.close()
            self._file = None
            self._journal.close()

    def __enter__(self):
        return self

    def __exit__(self, kind, error, traceback):
        self.close(complete=kind is None)


def run_file(path: PathLike) -> Path:
    """The run file meant by `path`: itself, or `run.vtkhdf` in a folder."""
    path = Path(path)
    return path if path.suffix in (".vtkhdf", ".hdf", ".h5") and not path.is_dir() else path / layout.RUN_FILE


def _unshare(path):
    """Give a run file that has other names too, as in a backup by links, bytes of its own before they change."""
    if path.stat().st_nlink > 1:
        part = part_of(path)
        with create_new(part) as copy, open(path, "rb") as file:
            shutil.copyfileobj(file, copy)
        os.replace(part, path)


def read_provenance(h5: h5py.File, path: PathLike = "run file") -> Record:
    """The provenance record of an open run file. Raises InputError, which names `path`, if it is invalid."""
    return read_record(h5["provenance/record"][()], f"{path}: provenance", PROVENANCE)


def read_hazard(h5: h5py.File, path: PathLike = "run file") -> dict[str, Any]:
    """The hazard record of an open run file, {} when it has none. Raises as `read_provenance`."""
    return read_record(h5["hazard/record"][()], f"{path}: hazard", HAZARD) if "hazard/record" in h5 else {}


def _create(h5, dimension, origin, units):
    h5.attrs.update(
        format=layout.FORMAT,
        format_version=layout.FORMAT_VERSION,
        dimension=int(dimension),
        origin=np.asarray(origin, np.float64),
        complete=False,
        field_units=json.dumps(units),
    )
    for name in ("terrain", "provenance", "maps"):
        h5.create_group(name)
    growing(h5.create_group("history"), "time", dtype=np.float64).attrs["units"] = "s"
    create_steps(h5.create_group("VTKHDF"))


def _drop_after(h5, until):
    """Drop the frames and history rows later than `until` [s], with a tolerance for the round-off of summed steps."""
    limit = until + 1e-9 * max(1.0, abs(until))
    keep_steps(h5["VTKHDF"], limit)
    # Finer rows come with the frames; those since the last frame are in the checkpoint, and come once more
    times = h5["VTKHDF/Steps/Values"][:]
    last = times[-1] + 1e-9 * max(1.0, abs(times[-1])) if len(times) else -np.inf
    keep_obstacles(h5, last, len(times))
    keep_surroundings(h5, len(times))
    keep_saw_test(h5, last)
    keep_series(h5, last)
    rows = int(np.searchsorted(h5["history/time"][:], limit, side="right"))
    for data in h5["history"].values():
        data.resize(rows, axis=0)


def _write_terrain(h5, terrain):
    if terrain is None:
        return
    vertices, facets = terrain
    facets = np.asarray(facets, np.int32)
    if facets.ndim != 2 or facets.shape[1] not in (2, 3):
        raise ValueError(f"terrain facets: shape {facets.shape}, must be (m, 2) or (m, 3)")
    data = h5["terrain"].create_dataset("vertices", data=as_rows(vertices).astype(np.float64), **COMPRESSION)
    data.attrs["units"] = "m"
    h5["terrain"].create_dataset("facets", data=facets, **COMPRESSION)


def _write_provenance(h5, record):
    _write_record(h5["provenance"], record)


def _write_record(group, record):
    if "record" in group:
        del group["record"]
    group["record"] = json.dumps(record, default=str)
