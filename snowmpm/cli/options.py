"""Arguments and options that several commands share."""

from enum import Enum
from pathlib import Path
from typing import Annotated

import typer

from snowmpm.cli import completion
from snowmpm.errors import InputError

NAMES_OF_FILES = ("file", "from")
"""Keys whose values are names of files or folders."""


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
BackendOption = Annotated[Backend, typer.Option(help="What computes; auto takes a CUDA GPU when there is one.")]
PrecisionOption = Annotated[Precision | None, typer.Option(help="Overrides solver.precision.")]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="Say nothing but warnings and errors.")]
Json = Annotated[bool, typer.Option("--json", help="Print one JSON object instead of words.")]
Fast = Annotated[
    bool, typer.Option("--fast", help="Trade accuracy for a third of the time or less; says what it changes.")
]
Accurate = Annotated[bool, typer.Option("--accurate", help="Trade time for half of the error; says what it changes.")]
Threads = Annotated[int | None, typer.Option(min=1, metavar="N", help="CPU threads; all cores by default.")]


def scene_overrides(settings, precision=None):
    """Overrides for `load_scene` from the texts of `--set` and from `--precision`.

    A value is read as TOML (a number, true, [..], "..."); what is no TOML value is text, so quotes may be left out.
    """
    overrides = setting_values(settings)
    if precision is not None:
        overrides["solver.precision"] = precision.value
    return overrides


def setting_values(settings):
    """Key -> value from the texts KEY=VALUE of `--set`, read as `scene_overrides` says.

    Names of files count from the current folder; one that is not there is left to the scene, whose own count from its
    file, and whose message says where it was looked for.
    """
    overrides = {}
    for setting in settings or ():
        key, equals, text = setting.partition("=")
        if not equals or not key.strip():
            raise InputError(f"--set {setting}: must be KEY=VALUE, such as solver.dx=0.05")
        overrides[key.strip()] = _from_here(key.strip().rpartition(".")[2], _value(key.strip(), text.strip()))
    return overrides


def _from_here(key, value):
    """A value whose file names that are found from the current folder are absolute."""
    if isinstance(value, dict):
        return {name: _from_here(name, item) for name, item in value.items()}
    if key not in NAMES_OF_FILES or not isinstance(value, str) or "\0" in value:
        return value
    path = Path(value).expanduser()
    try:
        return str(path.absolute()) if path.exists() else value
    except OSError:  # no name of a file: the scene says so
        return value


def _value(key, text):
    from snowmpm.reading.toml_text import TOMLDecodeError, tables

    try:
        parsed = tables(f"value = {text}", f"--set {key}")
    except TOMLDecodeError:
        return text
    return parsed["value"] if len(parsed) == 1 else text
