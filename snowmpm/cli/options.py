"""Arguments and options that several commands share."""

from enum import Enum
from pathlib import Path
from typing import Annotated

import typer

from snowmpm.cli import completion
from snowmpm.errors import InputError

NAMES_OF_FILES = ("file", "from")
"""Keys whose values are paths."""


class Backend(str, Enum):
    """What computes."""

    auto = "auto"
    cpu = "cpu"
    cuda = "cuda"


class Precision(str, Enum):
    """Bits of a number."""

    f32 = "f32"
    f64 = "f64"


SceneName = Annotated[
    str,
    typer.Argument(
        metavar="SCENE", help="Library scene (`snowmpm list`) or path of a TOML file.", autocompletion=completion.scenes
    ),
]
RunPath = Annotated[
    str, typer.Argument(metavar="RUN", help="Folder of a run, or its run.vtkhdf.", autocompletion=completion.runs)
]
Settings = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="KEY=VALUE",
        help="Change one key of the scene, e.g. --set solver.dx=0.05 or --set bodies.0.velocity=[1,0]; repeatable.",
        autocompletion=completion.keys,
    ),
]
BackendOption = Annotated[Backend, typer.Option(help="Device; auto takes a CUDA GPU if there is one.")]
PrecisionOption = Annotated[Precision | None, typer.Option(help="Overrides solver.precision.")]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="Print only warnings and errors.")]
Json = Annotated[bool, typer.Option("--json", help="Print one JSON object instead of text.")]
Fast = Annotated[
    bool, typer.Option("--fast", help="Run in a third of the time or less, with a larger error; prints the changes.")
]
Accurate = Annotated[bool, typer.Option("--accurate", help="Run with half of the error; prints the changes.")]
Threads = Annotated[int | None, typer.Option(min=1, metavar="N", help="CPU threads; all cores by default.")]


def scene_overrides(settings, precision=None):
    """Overrides for `load_scene` from the texts of `--set` and from `--precision`.

    A value is read as TOML (a number, true, [..], "..."). Anything else is text, so quotes may be left out.
    """
    overrides = setting_values(settings)
    if precision is not None:
        overrides["solver.precision"] = precision.value
    return overrides


def setting_values(settings):
    """Key -> value from the texts KEY=VALUE of `--set`, read as `scene_overrides` says.

    Paths are relative to the current folder. A path that does not exist there is passed on as it is: the scene resolves
    it from the folder of the scene file, and its error names the folder searched.
    """
    overrides = {}
    for setting in settings or ():
        key, equals, text = setting.partition("=")
        if not equals or not key.strip():
            raise InputError(f"--set {setting}: must be KEY=VALUE, such as solver.dx=0.05")
        overrides[key.strip()] = _from_here(key.strip().rpartition(".")[2], _value(key.strip(), text.strip()))
    return overrides


def _from_here(key, value):
    """The value with paths that exist in the current folder made absolute."""
    if isinstance(value, dict):
        return {name: _from_here(name, item) for name, item in value.items()}
    if key not in NAMES_OF_FILES or not isinstance(value, str) or "\0" in value:
        return value
    path = Path(value).expanduser()
    try:
        return str(path.absolute()) if path.exists() else value
    except OSError:  # not a path: the scene refuses it
        return value


def _value(key, text):
    from snowmpm.reading.toml_text import TOMLDecodeError, tables

    try:
        parsed = tables(f"value = {text}", f"--set {key}")
    except TOMLDecodeError:
        return text
    return parsed["value"] if len(parsed) == 1 else text
