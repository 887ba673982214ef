"""Checkpoints: the whole state of a run in one file, from which it continues as if never interrupted.

On a CPU, a resumed run is bitwise equal to an uninterrupted one, for any number of threads.
"""

import contextlib
import hashlib
import time as clock
import warnings
from numbers import Number
from pathlib import Path

import numpy as np

from snowmpm import __version__, plugins
from snowmpm.errors import InputError, shown_line
from snowmpm.io.archive import read_archive, write_archive
from snowmpm.methods import METHODS
from snowmpm.reading import toml_text

FILE = "checkpoint.npz"
FORMAT, FORMAT_VERSION = "snowmpm checkpoint", 4

KINDS = {"scene": str, "time": (int, float), "simulation": dict, "files": dict}
"""Keys of every checkpoint, besides that of its terrain."""

WALL_INTERVAL = 120.0
"""Seconds of wall time between checkpoints when the scene names no interval."""

LARGEST_SHARE = 0.05
"""Largest share of the wall time for such checkpoints."""

FREE_KEYS = ("end_time", "output.checkpoint_interval", "picture", "reference", "stop")
"""Keys, or whole tables, of a scene that may change between a checkpoint and its continuation."""


def save(simulation, path, **more):
    """Write the state of a simulation; the checkpoint that was there before becomes `previous(path)`.

    more: further state, dicts of numbers and arrays by name. Raises OSError when it cannot be written.
    """
    write_archive(path, snapshot(simulation, **more), keep=previous(path))


def snapshot(simulation, **more):
    """Content of a checkpoint: a copy of the whole state, unaffected by later steps of the simulation."""
    return {"format": FORMAT, "version": FORMAT_VERSION, "program": __version__, "scene": simulation.scene.to_toml(),
            "plugins": plugins.records(),
            "terrain": terrain_digest(simulation.model.surface), "files": simulation.files, "time": simulation.time,
            "simulation": simulation.state(), **more}


def restore(simulation, path):
    """Put a simulation of the same scene into the state of a checkpoint; -> the checkpoint (`read`).

    Raises InputError when there is no whole checkpoint or it belongs to another scene.
    """
    saved = read(path)
    check(saved, simulation.scene)
    take_over(simulation, saved)
    return saved


def take_over(simulation, saved):
    """Put a simulation into the state of a checkpoint that was read and checked."""
    scene = simulation.scene
    for key, digest in simulation.files.items():
        if saved["files"].get(key) != digest:
            raise InputError(f"{scene.source}: {key}: {_file(scene, key)} is not what it was when the run began: put it"
                             " back, or start anew")
    if saved.get("terrain") != terrain_digest(simulation.model.surface):
        raise InputError(f"{scene.source}: terrain: not what it was when the run began")
    with state_of(saved):
        _require_kinds(saved["simulation"], simulation.state(), "simulation")
        simulation.restore(saved["simulation"])


def _require_kinds(found, own, name):
    """TypeError where a saved state has another kind of value than the state of the simulation that takes it over: a
    text for a number would be met steps later."""
    if isinstance(own, dict):
        for key in own.keys() & found.keys():
            _require_kinds(found[key], own[key], key)
    elif isinstance(own, Number | np.ndarray) and not isinstance(found, np.ndarray if np.ndim(own) else Number):
        raise TypeError(f"{name}: {type(found).__name__} instead of {type(own).__name__}")


@contextlib.contextmanager
def state_of(saved):
    """Context: turns errors of restoring a checkpoint that does not fit into an InputError."""
    try:
        yield
    except (LookupError, TypeError, ValueError, AttributeError, OverflowError) as error:
        path, reason = saved.get("path", "checkpoint"), shown_line(error, 100) or type(error).__name__
        raise InputError(f"{path}: does not hold the state of this scene ({reason})") from error


def read(path):
    """The checkpoint at `path` as a dict, or the one before it when that is missing or damaged; "path": which one.

    Raises InputError if neither is whole, with the defect of the newer one.
    """
    path = Path(path)
    there = [candidate for candidate in (path, previous(path)) if candidate.exists()]
    if not there:
        raise InputError(f"{path.parent}: no checkpoint to resume from ({path.name} is missing)")
    problems = []
    for candidate in there:
        try:
            saved = read_archive(candidate)
        except InputError as error:
            problems.append(error)
            continue
        if saved.get("format") != FORMAT or saved.get("version") != FORMAT_VERSION:
            raise InputError(f"{candidate}: {saved.get('format')} version {saved.get('version')}; this program reads"
                             f" {FORMAT} version {FORMAT_VERSION}")
        for key, kind in KINDS.items():
            if not isinstance(saved.get(key), kind) or isinstance(saved[key], bool):
                raise InputError(f"{candidate}: {key} is missing or of another kind: not written by this program")
        if problems:
            warnings.warn(f"{problems[0]}; {candidate.name} is used, t = {saved['time']:.6g} s", stacklevel=2)
        return {**saved, "path": candidate}
    raise problems[0]


def previous(path):
    """Path of the checkpoint before the one at `path`: checkpoint.previous.npz for checkpoint.npz."""
    path = Path(path)
    return path.with_name(f"{path.stem}.previous{path.suffix}")


def check(saved, scene, accept_plugin=False):
    """Raise InputError for a scene that differs from the checkpoint's in more than a later end_time, and for plugins
    that are not loaded; accept_plugin: whether another version of one will do."""
    plugins.require(saved.get("plugins"), saved.get("path", "checkpoint"), accept_plugin)
    before = _flat(tables(saved["scene"]))
    for key, was, value in differences(saved["scene"], scene):
        was = f"was {was!r}" if was is not None else "was not there"
        allowed = f"{was} when the run began; a resumed run may change only end_time, to a later one"
        raise InputError.at(key, value, allowed, scene.source)
    if scene.end_time < before["end_time"]:
        allowed = f"was {before['end_time']:g} when the run began; a resumed run may end later, not earlier"
        raise InputError.at("end_time", scene.end_time, allowed, scene.source)


def differences(before, scene):
    """(key, value before, value now) of the differences between a resolved scene, as text, and a scene, without
    FREE_KEYS; None for a missing key. Files are compared by name only, a method's own table
    only if the scene uses the method."""
    before, now = _flat(tables(before)), _flat(tables(scene.to_toml()))
    method = now.get("solver.method")
    others = () if before.get("solver.method") != method else METHODS.values()
    idle = [f"solver.{entry.options}" for entry in others if entry.options and entry.name != method]
    for key in dict.fromkeys([*before, *now]):
        free = any(key == name or key.startswith(f"{name}.") for name in (*FREE_KEYS, *idle))
        if not free and before.get(key) != now.get(key):
            yield key, before.get(key), now.get(key)


def tables(text):
    """Tables of a resolved scene, from its text. Raises InputError where it cannot be read."""
    try:
        return toml_text.tables(text, "the scene of the earlier run")
    except toml_text.TOMLDecodeError:
        raise InputError("the scene of the earlier run is not readable") from None


def _flat(value, path=""):
    """{dotted key: value} of a scene; files count by name only, so that a run may be moved with its files."""
    if isinstance(value, dict) or (isinstance(value, list) and value and isinstance(value[0], dict)):
        items = value.items() if isinstance(value, dict) else enumerate(value)
        return {key: leaf for name, item in items for key, leaf in _flat(item, f"{path}.{name}".lstrip(".")).items()}
    if path.endswith(".file") or path == "initial.from":
        value = Path(value).name
    return {path: value}


def _file(scene, key):
    """Name of the file under a dotted key of a scene."""
    value = scene.model_dump(by_alias=True, warnings=False)
    for part in key.split("."):
        value = value[int(part)] if isinstance(value, list | tuple) else value[part]
    return Path(value).name


def terrain_digest(surface):
    """Digest of a terrain; None of none."""
    return None if surface is None else _digest([surface.vertices, surface.facets])


def _digest(arrays):
    if not arrays:
        return None
    digest = hashlib.sha256()
    for array in arrays:
        digest.update(np.ascontiguousarray(array))
    return digest.hexdigest()


class Checkpoints:
    """The checkpoints of one run: when the next is due, where the last one is."""

    def __init__(self, folder, interval):
        """interval: simulated time [s]; None: about every `WALL_INTERVAL` of wall time."""
        self.path = Path(folder) / FILE
        self.time = None
        """Simulated time of the last checkpoint that is whole on the disk [s]; None before the first."""
        self._asked = None
        self._interval = interval
        self._pause, self._saved_at = WALL_INTERVAL, clock.monotonic()

    def clear(self):
        """Remove the checkpoints of an earlier run."""
        for path in (self.path, previous(self.path)):
            path.unlink(missing_ok=True)

    def took_up(self, saved):
        """Continue from this checkpoint, so that a damaged newer one never replaces it."""
        self.time = self._asked = saved["time"]
        if saved["path"] != self.path:
            self.path.unlink(missing_ok=True)

    def due(self, time):
        """Whether the run should be saved at this simulated time [s]."""
        if self._interval is None:
            return clock.monotonic() - self._saved_at > self._pause
        return int(time / self._interval) > int(self._asked / self._interval)

    def save(self, simulation, background, **more):
        """Take the state now; `background` (`snowmpm.io.Background`) writes it, after the frames before it."""
        tree = snapshot(simulation, **more)
        self._asked, self._saved_at = simulation.time, clock.monotonic()
        background.do(lambda: self._write(tree), finished=True)

    def _write(self, tree):
        began = clock.monotonic()
        write_archive(self.path, tree, keep=previous(self.path))
        self.time, self._saved_at = tree["time"], clock.monotonic()
        self._pause = max(WALL_INTERVAL, (self._saved_at - began) / LARGEST_SHARE)

    def finish(self):
        """End of the run: keep only the last checkpoint, from which the run may be extended."""
        previous(self.path).unlink(missing_ok=True)

    def __str__(self):
        if self.time is None:
            return "no checkpoint was written"
        return f"last checkpoint: {self.path}, t = {self.time:.6g} s"
