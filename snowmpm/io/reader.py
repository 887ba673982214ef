"""Reading a run file: finished, still being written, or left behind by a program that was killed."""

import importlib
import time as clock
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import h5py
import numpy as np
from numpy.typing import NDArray

from snowmpm.annotations import Floats, Numbers, PathLike
from snowmpm.errors import InputError, did_you_mean, shown_line
from snowmpm.glance import ArraysGlance, Glance, counted
from snowmpm.io import layout
from snowmpm.io.contents import allow_rows, check_contents
from snowmpm.io.ground_maps import Map, Terrain
from snowmpm.io.obstacles import Obstacle, read_obstacles
from snowmpm.io.records import LONGEST, SUMMARY, Record, read_record
from snowmpm.io.rows import units_of
from snowmpm.io.saw_test import SawTest, read_saw_test
from snowmpm.io.scenario import scenario_of
from snowmpm.io.series import Series, read_series
from snowmpm.io.status import status_of
from snowmpm.io.transaction import SnapshotFile
from snowmpm.io.writer import read_hazard, read_provenance, run_file
from snowmpm.quantities.table import OLD_NUMBERS, PASSED, RENAMED, renamed
from snowmpm.reading import budget as read_budget
from snowmpm.reading.toml_text import TOMLDecodeError, tables

if TYPE_CHECKING:  # of extras
    import pandas
    import xarray

ATTEMPTS = 200

T = TypeVar("T")


@dataclass(frozen=True, repr=False)
class Frame(ArraysGlance):
    """The particles at one time: points (n, 3) float32 [m] relative to the run's origin (3,) [m], fields by name.

    positions: (n, 3) float64 [m] in map coordinates, those of the scene.  to_pyvista() -> snow, terrain, obstacles
    """

    time: float
    points: NDArray[np.float32]
    fields: dict[str, Numbers]
    origin: Floats = field(default_factory=lambda: np.zeros(3))
    _of: "tuple[Run | None, int]" = field(default=(None, 0), compare=False)

    def to_pyvista(self) -> Any:
        """The frame as a `pyvista.MultiBlock` in map coordinates [m]: block "snow" with the fields of the particles,
        "terrain" (triangles, or lines of a section), and each obstacle by its name, where it is in this frame.
        `blocks["snow"].user_dict["units"]` has the units of the fields by name."""
        return _drawing("pyvista_sets").blocks_of(self, *self._of)

    @property
    def positions(self) -> Floats:
        return self.points + self.origin

    def __len__(self) -> int:
        return len(self.points)


class Run(Glance):
    """One run, from its folder or its file.

    It shows the state at opening or at the last `refresh`; frames are read from the disk on demand.

    path, name (of its scene, or else of its folder), dimension (2 or 3), origin (3,) [m]
    complete (the run reached its end)
    times (frames,) [s];  len(run) frames;  run.frame(i) -> Frame;  for frame in run
    field_names;  field_kinds: (type, columns or None) by name
    units of fields and history by name;  history: arrays by name, "time" among them
    scene: tables of the resolved scene
    terrain -> Terrain or None;  obstacles: `snowmpm.io.obstacles.Obstacle` by name;  maps: Map by name;  provenance
    hazard: run-out, affected area, profile along the thalweg, or {};  saw_test -> `snowmpm.io.saw_test.SawTest` or None
    summary (summary.json, or {})

    Raises InputError if there is no run, or its format is unknown.
    """

    path: Path
    dimension: int
    origin: Floats
    complete: bool
    times: Floats
    field_names: list[str]
    field_kinds: dict[str, tuple[np.dtype[Any], int | None]]
    units: dict[str, str]
    history: Record

    def __init__(self, path: PathLike) -> None:
        self.path = run_file(path)
        if not self.path.is_file() and Path(path).suffix == ".toml":
            raise InputError(f"{path}: is a scene, not a run; {_run_of(path)}")
        if not self.path.is_file():
            raise InputError(f"{path}: no run file here ({layout.RUN_FILE} is missing){_runs_near(path)}")
        self.refresh()

    def refresh(self) -> None:
        """Reread the file for new frames and history rows."""
        for name in ("terrain", "obstacles", "saw_test", "series", "maps", "_rasters", "provenance", "scene", "hazard",
                     "summary"):
            self.__dict__.pop(name, None)
        self._checked = False
        """Whether the content was checked: once only, since a fast writer would always be ahead."""
        self._read(self._read_index)

    def _read_index(self, h5: h5py.File) -> None:
        root, attributes = h5["VTKHDF"], h5.attrs
        if attributes.get("format") != layout.FORMAT:
            raise InputError(f"{self.path}: not a run file of this program")
        if int(attributes["format_version"]) > layout.FORMAT_VERSION:
            version = int(attributes["format_version"])
            raise InputError(f"{self.path}: format version {version}; this program reads up to {layout.FORMAT_VERSION}")
        if not self._checked:
            check_contents(h5, self.path)
            self._checked = True
        self.dimension = int(attributes["dimension"])
        self.origin = np.array(attributes["origin"])
        self._shift = self.origin if int(attributes["format_version"]) > 1 else np.zeros(3)
        self.complete = bool(attributes["complete"])
        steps, count = root["Steps"], int(root["Steps"].attrs["NSteps"])
        self.times = steps["Values"][:count]
        self._starts = steps["PointOffsets"][:count]
        self._counts = root["NumberOfPoints"][:count]
        self.field_names = list(root["PointData"])
        self.field_kinds = {name: (data.dtype, data.shape[1] if data.ndim > 1 else None)
                            for name, data in root["PointData"].items()}
        history = renamed({name: data[:] for name, data in h5["history"].items()}, RENAMED)
        self.history = Record(history, f"{self.path}: history")
        named = [*root["PointData"].items(), *h5["history"].items()]
        self.units = renamed({name: units_of(data) for name, data in named}, RENAMED)

    def _read(self, action: Callable[[h5py.File], T]) -> T:
        """`action(open file)`, repeated if a commit happened meanwhile, so that it sees one state only."""
        for _ in range(ATTEMPTS):
            failure: Exception | None = None
            try:
                with self._snapshot() as (h5, snapshot):
                    try:
                        result = action(h5)
                    except InputError:
                        if snapshot.is_current():  # otherwise the data mix two states
                            raise
                    else:
                        if snapshot.is_current():
                            return result
            except InputError:
                raise
            except Exception as error:  # damaged bytes raise many kinds of errors in HDF5, NumPy and JSON
                failure = error
            if failure is not None and not self._being_written():
                reason = " ".join(str(failure).split())[:200]
                raise InputError(f"{self.path}: not a readable run file ({reason})") from failure
            clock.sleep(0.02)
        raise InputError(f"{self.path}: is being written faster than it can be read; try again later")

    @contextmanager
    def _snapshot(self) -> Iterator[tuple[h5py.File, SnapshotFile]]:
        with SnapshotFile(self.path) as snapshot, h5py.File(snapshot, "r") as h5:
            yield h5, snapshot

    def _being_written(self) -> bool:
        with SnapshotFile(self.path) as snapshot:
            return snapshot.counter is not None

    def __len__(self) -> int:
        return len(self.times)

    def n_points(self, i: int) -> int:
        """Number of particles in frame `i`, without reading it."""
        return int(self._counts[i])

    def frame(self, i: int, fields: Iterable[str] | None = None) -> Frame:
        """Frame `i` (negative from the end); only the named `fields`, by default all of them."""
        start, n = int(self._starts[i]), int(self._counts[i])
        names = self.field_names if fields is None else list(fields)
        for name in names:
            if name not in self.field_names:
                raise InputError.not_in("field", name, self.field_names, file=self.path)

        def action(h5: h5py.File) -> tuple[NDArray[np.float32], dict[str, Numbers]]:
            root = h5["VTKHDF"]
            rows = [root["Points"], *(root["PointData"][name] for name in names)]
            allow_rows(self.path, f"frame {i}", n, rows)
            points = (root["Points"][start : start + n] - self._shift).astype(np.float32)
            return points, {name: root["PointData"][name][start : start + n] for name in names}

        points, values = self._read(action)
        return Frame(float(self.times[i]), points, values, self.origin, (self, range(len(self))[i]))

    def __iter__(self) -> Iterator[Frame]:
        return (self.frame(i) for i in range(len(self)))

    def to_xarray(self, what: str = "history") -> "xarray.Dataset":
        """A part of the run as an `xarray.Dataset` with units, long names and map coordinates:

        history     the time series, over time
        particles   fields and "position" over time, particle and, of vectors and tensors, axis or component; frames are
                    read on demand. Removed particles are NaN. The order of rows changes between frames:
                    output.fields = [..., "id"] identifies particles
        maps        rasters in plan over y and x, of a run in 3-D at its end
        saw_test    over time and x along the column

        Raises InputError for another name, a run without it, or when xarray is missing.
        """
        from snowmpm.io.datasets import dataset

        return dataset(self, what)

    def to_pandas(self, what: str = "history") -> "pandas.DataFrame":
        """A table of the run as a `pandas.DataFrame`:

        history     the time series, indexed by time
        summary     content of summary.json;  saw_test  results of a saw test beside theory
        hazard      numbers of hazard mapping with their units;  thalweg  profile, indexed by the distance along it
        loads       on obstacles, indexed by obstacle and time
        panels      peak and impulse of pressure panels, indexed by obstacle, row and column

        `.attrs["units"]` has the units by column, `.attrs["not_final"]` the reasons why numbers are not final. Raises
        InputError for another name, a run without it, or when pandas is missing.
        """
        from snowmpm.io.tables import table

        return table(self, what)

    def plot(self, *names: str) -> Any:
        """`snowmpm.render.inline.Pictures` that a notebook shows inline: maps by name, "still", "history", "thalweg",
        "thalweg_time", "saw_test", "compression"; by default what tells most, and the history. Raises InputError for
        what the run does not have."""
        return _drawing("inline").plot(self, *names)

    def show(self, color: str | None = None, camera: str | None = None) -> Any:
        """The run in motion, to be turned by hand, as a `snowmpm.render.inline.View`: a notebook shows it, also without
        a network; `save(path)` writes it as a page. color, camera, errors: as of `snowmpm.render.render_run`."""
        return _drawing("inline").show(self, color=color, camera=camera)

    def plotter(self, i: int = -1, color: str | None = None, **options: Any) -> Any:
        """A `pyvista.Plotter` with frame i: snow coloured by a field, by default the speed, terrain and obstacles.
        options: of `pyvista.Plotter`, such as off_screen=True. See `snowmpm.render.inline.plotter`."""
        return _drawing("inline").plotter(self, i, color, **options)

    def _repr_html_(self) -> str:
        picture = _drawing("inline").thumbnail(self) if len(self) else ""
        return (f'<div style="display:flex;flex-wrap:wrap;gap:1em;align-items:start"><div>{super()._repr_html_()}</div>'
                f"{picture}</div>")

    def _glance(self) -> tuple[str, dict[str, Any]]:
        counts = sorted({self.n_points(i) for i in range(len(self))})
        particles = " to ".join(counted(n) for n in dict.fromkeys((counts[0], counts[-1]))) if counts else "none yet"
        facts = {"file": self.path, "frames": f"{len(self)}" + (f", {self.times[0]:g} to {self.times[-1]:g} s"
                                                                if len(self) else ""),
                 "particles": particles,
                 "fields": ", ".join(_with_unit(name, self.units) for name in self.field_names),
                 "history": f"{len(self.history['time'])} rows of {', '.join(self.history)}"}
        parts: dict[str, dict[str, Any]] = {"obstacles": self.obstacles, "maps": self.maps}
        facts |= {name: ", ".join(part) for name, part in parts.items() if part}
        if self.hazard.get("numbers"):
            facts["result"] = status_of(self).text
        facts |= {"also": ", ".join(name for name, part in (("terrain", self.terrain), ("saw_test", self.saw_test),
                                                            ("hazard", self.hazard)) if part)}
        state = "complete" if self.complete else f"not complete, up to {self.times[-1] if len(self) else 0.0:g} s"
        return f"Run {self.name} ({self.dimension}-D, {state})", {name: text for name, text in facts.items() if text}

    @property
    def name(self) -> str:
        return shown_line(self.provenance.get("scene_name") or self.path.parent.name, LONGEST)

    @property
    def title(self) -> str:
        """Its name, and what tells it apart from other runs of the scene (`snowmpm.io.scenario`)."""
        scenario = scenario_of(self.path.parent, self.name)
        return f"{self.name}, {scenario}" if scenario else self.name

    @cached_property
    def terrain(self) -> Terrain | None:
        return self._read(_read_terrain)

    @cached_property
    def obstacles(self) -> dict[str, Obstacle]:
        return self._read(read_obstacles)

    @cached_property
    def saw_test(self) -> SawTest | None:
        return self._read(lambda h5: read_saw_test(h5, self.path))

    @cached_property
    def series(self) -> dict[str, dict[str, Series]]:
        """What components recorded finer than the frames, by kind and name."""
        return self._read(lambda h5: read_series(h5, self.path))

    @cached_property
    def maps(self) -> dict[str, Map]:
        hidden = [one.name for one in PASSED]
        return {name: raster for name, raster in self._rasters.items() if name not in hidden}

    @property
    def passed(self) -> tuple[Map, Map] | None:
        """Volume that passed a metre of width, to the east and to the north (`snowmpm.quantities.table.PASSED`)."""
        found = [self._rasters[one.name] for one in PASSED if one.name in self._rasters]
        return (found[0], found[1]) if len(found) == len(PASSED) else None

    @cached_property
    def _rasters(self) -> dict[str, Map]:
        return self._read(lambda h5: {name: _read_map(data) for name, data in h5["maps"].items()})

    @cached_property
    def provenance(self) -> Record:
        return self._read(lambda h5: read_provenance(h5, self.path))

    @cached_property
    def scene(self) -> Record:
        """Tables of the resolved scene. Raises InputError if the provenance has no readable scene."""
        try:
            return Record(tables(self.provenance["scene"], self.path), f"{self.path}: its scene")
        except TOMLDecodeError:
            raise InputError(f"{self.path}: the scene in it is not readable") from None

    @cached_property
    def hazard(self) -> dict[str, Any]:
        record = self._read(lambda h5: read_hazard(h5, self.path))
        if record.get("numbers"):
            record["numbers"] = Record(renamed(record["numbers"], OLD_NUMBERS), record["numbers"].file)
        return record

    @cached_property
    def summary(self) -> dict[str, Any]:
        path = self.path.with_name(layout.SUMMARY_FILE)
        if not path.is_file():
            return {}
        try:
            read_budget.allow(path, float(path.stat().st_size), "its text")
            return read_record(path.read_bytes(), path, SUMMARY)
        except OSError as error:
            raise InputError(f"{path}: not readable ({error.strerror})") from None


def _drawing(name: str) -> Any:
    """A module of what draws runs. It reads them; only here, where a user asks a run to show itself, a run asks it."""
    return importlib.import_module(f"snowmpm.render.{name}")


def _with_unit(name: str, units: Mapping[str, str]) -> str:
    unit = units.get(name, "")
    return name if unit in ("", "1") else f"{name} [{unit}]"


def _run_of(scene: PathLike) -> str:
    """The usual folder of the run of a scene, or how to make one."""
    usual = Path("runs") / Path(scene).stem
    return f"did you mean {usual}?" if (usual / layout.RUN_FILE).exists() else f"snowmpm run {scene} makes one"


def _runs_near(path: PathLike) -> str:
    """"; did you mean FOLDER?" with a folder beside `path` that holds a run and has a similar name, or ""."""
    folder = Path(path).parent
    runs = [str(file.parent) for file in sorted(folder.glob(f"*/{layout.RUN_FILE}"))] if folder.is_dir() else []
    return did_you_mean(str(Path(path)), runs)


def _read_terrain(h5: h5py.File) -> Terrain | None:
    group = h5["terrain"]
    return Terrain(group["vertices"][:], group["facets"][:]) if "vertices" in group else None


def _read_map(data: h5py.Dataset) -> Map:
    x0, y0, cell = (float(data.attrs[name]) for name in ("x0", "y0", "cell"))
    return Map(data[:], x0, y0, cell, units_of(data))
