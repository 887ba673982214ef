"""What the shell offers when a name is begun: scenes, runs, materials, fields, keys of a scene.

Each function takes what was typed so far and returns the names that begin so. The library's names are read from its
folder, since importing the scenes takes longer than a person waits for a completion.
"""

import glob
import importlib.util
import os
from pathlib import Path

ENDINGS_OF_MESHES = (".stl", ".obj", ".ply", ".asc", ".tif", ".tiff")


def scenes(incomplete: str):
    """Library scenes with what they show, then TOML files and folders."""
    yield from _described(_library(), incomplete)
    yield from _paths(incomplete, (".toml",))


def library_scenes(incomplete: str):
    """Library scenes with what they show."""
    yield from _described(_library(), incomplete)


def cards(incomplete: str):
    """Material cards, then TOML files and folders."""
    yield from sorted(path.stem for path in (_library() / "materials").glob(f"{glob.escape(incomplete)}*.toml"))
    yield from _paths(incomplete, (".toml",))


def runs(incomplete: str):
    """Folders that hold a run, and folders on the way to one; "runs/" first, where runs go by default."""
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
    """Keys of the scene that the command line names, with their values: solver.dx=0.25."""
    from snowmpm.errors import InputError
    from snowmpm.scenes import load_scene

    try:
        data = load_scene(ctx.params.get("scene") or "slab_release_2d").model_dump(exclude_none=True)
    except InputError:
        return []
    return [(f"{key}=", str(value)) for key, value in _dotted(data) if key.startswith(incomplete)]


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


def _dotted(value, key=""):
    """(dotted key, value) of everything in tables and lists of tables."""
    if isinstance(value, dict):
        for name, item in value.items():
            yield from _dotted(item, f"{key}.{name}" if key else name)
    elif isinstance(value, list | tuple) and value and isinstance(value[0], dict):
        for i, item in enumerate(value):
            yield from _dotted(item, f"{key}.{i}")
    else:
        yield key, value
