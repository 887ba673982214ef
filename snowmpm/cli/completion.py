"""Tab completion of scenes, runs, materials, fields and keys of a scene.

Each function takes the text typed so far and returns the names that begin with it. The library's names are read from
its folder, since importing the scenes would delay the completion noticeably.
"""

import glob
import importlib.util
import os
from pathlib import Path

ENDINGS_OF_MESHES = (".stl", ".obj", ".ply", ".glb", ".asc", ".tif", ".tiff")


def scenes(incomplete: str):
    """Library scenes with their titles, then TOML files and folders."""
    yield from _described(_library(), incomplete)
    yield from _paths(incomplete, (".toml",))


def library_scenes(incomplete: str):
    """Library scenes with their titles."""
    yield from _described(_library(), incomplete)


def cards(incomplete: str):
    """Material cards, then TOML files and folders."""
    yield from sorted(path.stem for path in (_library() / "materials").glob(f"{glob.escape(incomplete)}*.toml"))
    yield from _paths(incomplete, (".toml",))


def runs(incomplete: str):
    """Folders that hold a run, and folders above one; "runs/", the default place of runs, first."""
    for folder in _folders(incomplete):
        if (Path(folder) / "run.vtkhdf").exists():
            yield folder
        elif any(Path(folder).glob("*/run.vtkhdf")):
            yield f"{folder}/"
            yield from (str(file.parent) for file in sorted(Path(folder).glob("*/run.vtkhdf")))


def grounds(incomplete: str):
    """Meshes, elevation rasters and folders."""
    yield from _paths(incomplete, ENDINGS_OF_MESHES)


def fields(ctx, incomplete: str):
    """Fields of the run that the command line names, and plain snow."""
    from snowmpm.errors import InputError
    from snowmpm.io import Run

    named = ctx.params.get("run") or ctx.params.get("runs")
    try:
        known = Run(named[0] if isinstance(named, list | tuple) else named).field_names
    except (InputError, TypeError, IndexError):
        known = ["velocity", "density", "material", "damage"]
    return [name for name in [*known, "snow"] if name.startswith(incomplete)]


def tests(incomplete: str):
    """Tests of a material at a point."""
    from snowmpm.materials import EXPERIMENTS

    return [(name, experiment.summary) for name, experiment in EXPERIMENTS.items() if name.startswith(incomplete)]


def keys(ctx, incomplete: str):
    """Keys of the scene that the command line names, set or not, with their values or meaning: solver.dx=0.25; after
    the "=" the allowed words.
    """
    from snowmpm.errors import InputError
    from snowmpm.scenes import load_scene
    from snowmpm.scenes.keytree import all_keys, values_at
    from snowmpm.scenes.messages import schema_of
    from snowmpm.scenes.saw_test import MADE

    try:
        scene = load_scene(ctx.params.get("scene") or "slab_release_2d")
    except InputError:
        return []
    schema, data = schema_of(type(scene)), scene.model_dump(exclude_none=True, by_alias=True)
    key, equals, begun = incomplete.partition("=")
    if equals:
        path = [int(part) if part.isdigit() else part for part in key.split(".")]
        words = [str(value).lower() if isinstance(value, bool) else str(value)
                 for value in values_at(schema, path, data)]
        return [f"{key}={word}" for word in words if word.startswith(begun)]
    # [saw_test] creates some tables itself and refuses them as input; other scenes have no such table
    made = MADE if scene.saw_test else ("saw_test",)
    found = [(".".join(map(str, path)), value, about) for path, value, about in all_keys(schema, data)
             if path[0] not in made]
    return [(f"{name}=", about.split("\n")[0] if value is None else str(value)) for name, value, about in found
            if name.startswith(key)]


def _library():
    # The folder of snowmpm.scenes, without importing it
    return Path(importlib.util.find_spec("snowmpm.scenes").submodule_search_locations[0]) / "library"


def _described(folder, incomplete):
    for path in sorted(folder.glob(f"{glob.escape(incomplete)}*.toml")):
        with path.open(encoding="utf-8") as lines:
            yield path.stem, next(lines, "").lstrip("# ").strip()


def _paths(incomplete, endings):
    for found in sorted(glob.glob(f"{glob.escape(incomplete)}*")):
        if os.path.isdir(found):
            yield f"{found}/"
        elif found.lower().endswith(endings):
            yield found


def _folders(incomplete):
    return [found.rstrip("/") for found in sorted(glob.glob(f"{glob.escape(incomplete)}*")) if os.path.isdir(found)]
