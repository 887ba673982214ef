"""Plugins: modules of others that add laws, events, shapes, methods or commands to the program (`snowmpm.registry`).

    snowmpm.register(MyLaw)                        in a script, before it loads a scene
    snowmpm run scene.toml --plugin my_law.py      a file, or a module that is installed
    [project.entry-points."snowmpm.plugins"]       in the pyproject.toml of a package that is installed
    my_laws = "my_laws"

A run holds name, version and SHA-256 of the plugins that were loaded. Nothing that a scene, a campaign, a run or a
checkpoint names is ever imported.
"""

import hashlib
import importlib
import importlib.metadata
import importlib.util
import sys
import warnings
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from importlib.machinery import ModuleSpec
from pathlib import Path
from types import ModuleType
from typing import Any, TypeVar

from snowmpm import registry
from snowmpm.errors import InputError, shown_line

T = TypeVar("T")

GROUP = "snowmpm.plugins"
"""Entry points of installed packages that are loaded by every command that computes."""

_loaded: dict[str, "Plugin"] = {}
_loading: list[str] = []


@dataclass(frozen=True)
class Plugin:
    """What a run says of a plugin. sha256: of its files, "" where they are not known."""

    name: str
    version: str
    sha256: str
    source: str
    """what it was loaded by, for processes that this one starts; no file holds it"""

    def record(self) -> dict[str, str]:
        """What a run keeps."""
        return {name: value for name, value in asdict(self).items() if name != "source"}


def loaded() -> tuple[Plugin, ...]:
    """Plugins that are loaded, in their order."""
    return tuple(_loaded.values())


def load(source: str, sha256: str | None = None) -> Plugin:
    """Load a plugin: a file that ends in .py, or a module that is installed; -> what a run will say of it.

    sha256: that it must have, else it is not run. A plugin that is loaded already is left as it is. Raises InputError
    where it is not there, has another digest, or raises an error itself.
    """
    path = Path(source).expanduser()
    file = path.suffix == ".py"
    name, source = (path.stem, str(path.resolve())) if file else (source, source)
    known = _loaded.get(name)
    if known and known.source != source:
        raise InputError(f"--plugin {source}: another plugin of the name {name} is loaded")
    _loading.append(name)
    try:
        spec = _spec(path, f"snowmpm_plugin_{name}") if file else importlib.util.find_spec(name)
        if spec is None:
            raise InputError(f"--plugin {source}: no such {'file' if file else 'module'}")
        digest = known.sha256 if known else _digest(spec.origin, spec.submodule_search_locations)
        if sha256 not in (None, digest):
            raise InputError(f"--plugin {source}: is not the one that the others were given: it has another SHA-256")
        if not known:
            _loaded[name] = Plugin(name, _version(_run(spec) if file else importlib.import_module(name), name), digest,
                                   source)
    except (InputError, KeyboardInterrupt):
        raise
    except BaseException as error:  # SystemExit too: a plugin does not end the program
        said = shown_line(f"{type(error).__name__}: {error}", 200)
        raise InputError(f"--plugin {source}: cannot be loaded ({said})") from error
    finally:
        _loading.pop()
    return _loaded[name]


def load_installed() -> None:
    """Load the plugins that installed packages name as entry points of the group `snowmpm.plugins`."""
    for point in importlib.metadata.entry_points(group=GROUP):
        try:
            load(point.value.partition(":")[0])
        except InputError as error:
            said = str(error).removeprefix(f"--plugin {point.value.partition(':')[0]}: ")
            raise InputError(f"the installed plugin {point.name}: {said}; --no-plugins goes on without it") from error


def register(entry: T) -> T:
    """Add a law, law of ground friction, event, force, shape, field, method or command to the program; -> the same, so
    that it decorates a class. Scenes that are loaded afterwards may name it.

    Raises InputError for anything else, and for a name that is taken.
    """
    by = sys._getframe(1).f_globals.get("__name__", "__main__")
    registry.register(entry, by)
    # Of a module that a script imports, its whole package, as `--plugin` would load it
    if not _loading and (module := sys.modules.get(by.partition(".")[0])):
        path = vars(module).get("__file__")
        name = Path(path).stem if by == "__main__" and path else module.__name__
        _loaded[name] = Plugin(name, _version(module, name), _digest(path, vars(module).get("__path__")), "")
    return entry


def records() -> list[dict[str, str]]:
    """What a run keeps of the plugins that are loaded."""
    return [plugin.record() for plugin in _loaded.values()]


def require(saved: Any, where: object, accept: bool = False) -> None:
    """Raise InputError unless the plugins that a run or checkpoint names are loaded.

    saved: `records()` of then, which may come from anybody. accept: whether another version of one will do.
    """
    for one in saved if isinstance(saved, list) else ():
        if not isinstance(one, dict) or not all(isinstance(one.get(key), str) for key in ("name", "version", "sha256")):
            raise InputError(f"{where}: its plugins are not readable")
        name = shown_line(" ".join([one["name"], one["version"]]).strip(), 100)
        now = _loaded.get(one["name"])
        if now is None:
            raise InputError(f"{where}: was made with the plugin {name}, which is not loaded: give it with --plugin, or"
                             " install it")
        if "" in (one["sha256"], now.sha256):
            warnings.warn(f"{where}: whether the plugin {name} is the one that it was made with cannot be told",
                          stacklevel=2)
        elif one["sha256"] != now.sha256 and not accept:
            raise InputError(f"{where}: was made with another plugin {name}: SHA-256 {shown_line(one['sha256'][:12])}"
                             f" then, {now.sha256[:12]} now;\n--accept-plugin takes the one of now")


def _spec(path: Path, name: str) -> ModuleSpec | None:
    return importlib.util.spec_from_file_location(name, path) if path.is_file() else None


def _run(spec: ModuleSpec) -> ModuleType:
    """The module of a file."""
    assert spec.loader is not None  # of a file that ends in .py
    module = sys.modules[spec.name] = importlib.util.module_from_spec(spec)
    try:
        spec.loader.exec_module(module)
    except BaseException:
        del sys.modules[spec.name]
        raise
    return module


def _version(module: ModuleType, name: str) -> str:
    own = vars(module).get("__version__")
    if isinstance(own, str):
        return own
    try:
        return importlib.metadata.version(name.partition(".")[0])
    except importlib.metadata.PackageNotFoundError:
        return ""


def _digest(origin: str | None, folders: Iterable[str] | None) -> str:
    """SHA-256 of the file of a module, or of all Python files of a package; "" where there are none.

    origin, folders: of a `ModuleSpec`.
    """
    files = [(path.relative_to(folder).as_posix(), path) for folder in map(Path, folders or ())
             for path in sorted(folder.rglob("*.py"))]
    if not files and origin and Path(origin).is_file():
        files = [(Path(origin).name, Path(origin))]
    digest = hashlib.sha256()
    for name, path in files:
        content = path.read_bytes()
        digest.update(f"{name} {len(content)}\n".encode() + content)
    return digest.hexdigest() if files else ""
