"""From a name or a TOML file to a validated scene."""

import contextlib
import copy
import re
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pydantic import ValidationError
from pydantic_core import PydanticCustomError

from snowmpm.annotations import PathLike
from snowmpm.errors import InputError, nearest, nearest_file
from snowmpm.reading.toml_text import MAX_DEPTH
from snowmpm.scenes.cards import with_cards
from snowmpm.scenes.library import FOLDER, library
from snowmpm.scenes.messages import describe, dotted, shown
from snowmpm.scenes.schema import Scene
from snowmpm.scenes.space import surroundings
from snowmpm.scenes.toml import parse

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib


def load_scene(name_or_path: PathLike, overrides: Mapping[str, Any] | None = None) -> Scene:
    """Load and validate a scene.

    name_or_path: name of a library scene, `event:NAME` of an observed avalanche, or path of a TOML file.
    overrides: dotted key -> value, set before validation: {"solver.dx": 0.05, "bodies.0.velocity": [1.0, 0.0]}.
    Raises InputError, which names file, key, value and what is allowed.
    """
    path = find_scene(name_or_path)
    data = parse(path)
    for key, value in (overrides or {}).items():
        override(data, key, value, path)
    base_dir = path.resolve().parent
    # Before validation, so that messages include the numbers of the card; validation reports errors of a card
    with surroundings(base_dir=base_dir), contextlib.suppress(PydanticCustomError):
        data = with_cards(data)
    try:
        with surroundings(base_dir=base_dir):
            scene = Scene.model_validate(data)
    except ValidationError as error:
        raise InputError(describe(error, data, Scene, path)) from None
    except RecursionError:
        raise InputError(f"{path}: nested too deeply") from None
    scene._base_dir, scene._source, scene._overrides = base_dir, str(path), dict(overrides or {})
    return scene


def with_overrides(scene: Scene, overrides: Mapping[str, Any]) -> Scene:
    """A loaded scene with other values of some keys, as `load_scene` takes them. Raises InputError."""
    data = tomllib.loads(scene.to_toml())
    for key, value in overrides.items():
        override(data, key, value, scene.source)
    try:
        with surroundings(base_dir=scene.base_dir):
            changed = Scene.model_validate(data)
    except ValidationError as error:
        raise InputError(describe(error, data, Scene, scene.source)) from None
    changed._base_dir, changed._source = scene.base_dir, scene.source
    changed._overrides = {**scene.overrides, **overrides}
    return changed


def find_scene(name_or_path: PathLike) -> Path:
    """Path of a scene: a TOML file as given, the file of a library scene, or of an observed avalanche (`event:NAME`),
    whose files are fetched. Raises InputError if there is none."""
    if isinstance(name_or_path, str) and name_or_path.startswith("event:"):
        from snowmpm.events.store import scene_file

        return scene_file(name_or_path.removeprefix("event:"))
    path = Path(name_or_path)
    named = isinstance(name_or_path, str) and path.suffix != ".toml" and path.name == name_or_path
    if named and not path.is_file():
        names = library()
        if name_or_path in names:
            return FOLDER / f"{name_or_path}.toml"
        near = nearest(name_or_path, names)
        hint = f"did you mean {near}?" if near else "`snowmpm list` names them; a file ends in .toml"
        raise InputError(f"no scene {shown(name_or_path)} in the library: {hint}")
    if not path.is_file():
        if path.is_dir():
            raise InputError(f"{path}: a folder, not a scene file")
        raise InputError(f"{path}: no such file{nearest_file(path)}")
    return path


def override(data: dict[str, Any], key: str, value: Any, path: object) -> None:
    """Set one dotted key, making the tables on its way; entries of lists are addressed by their index."""
    parts = key.split(".")
    if len(parts) > MAX_DEPTH:
        raise _misplaced(path, key, value, f"a key has at most {MAX_DEPTH} parts")
    here, value = data, copy.deepcopy(value)  # which a longer key may change
    for i, part in enumerate(parts):
        last = i == len(parts) - 1
        if isinstance(here, list):
            if not re.fullmatch("[0-9]{1,9}", part) or int(part) >= len(here):
                entries = f"entries 0 to {len(here) - 1}" if here else "no entries"
                raise _misplaced(path, key, value, f"{'.'.join(parts[:i])} is a list with {entries}")
            part = int(part)
        elif not isinstance(here, dict):
            raise _misplaced(path, key, value, f"{'.'.join(parts[:i])} = {shown(here)} has no keys")
        elif not part:
            raise _misplaced(path, key, value, "must be a dotted key such as solver.dx")
        if last:
            here[part] = value
        elif isinstance(here, list):
            here = here[part]
        else:
            here = here.setdefault(part, {})


def _misplaced(path: object, key: str, value: Any, why: str) -> InputError:
    return InputError(f"{path}: {dotted(key.split('.'))} = {shown(value)}: {why}")
