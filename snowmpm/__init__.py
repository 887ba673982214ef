"""snowmpm: snow and avalanche mechanics at finite strain.

    import snowmpm
    scene = snowmpm.load_scene("slab_release_2d", {"solver.dx": 0.05})
    run = snowmpm.run(scene, "runs/slab")
    run = snowmpm.open_run("runs/slab")

Importing the package starts nothing: names below are loaded when first used.
"""

import importlib
import os
from contextlib import nullcontext
from typing import TYPE_CHECKING

from snowmpm import home, notebook

if TYPE_CHECKING:  # they take time to import
    from collections.abc import Callable

    from snowmpm.annotations import PathLike
    from snowmpm.campaigns.launch import campaign
    from snowmpm.compiler.runtime import start
    from snowmpm.io import Run
    from snowmpm.plugins import register
    from snowmpm.running.loop import Progress
    from snowmpm.running.simulation import Simulation
    from snowmpm.scenes import Scene, load_scene

__version__ = "0.2.0"

os.environ.setdefault("ENABLE_TAICHI_HEADER_PRINT", "0")  # a library does not print when it is imported
home.provide()  # before Taichi is imported

_HOMES = {"load_scene": "snowmpm.scenes", "Simulation": "snowmpm.running.simulation", "Run": "snowmpm.io",
          "register": "snowmpm.plugins", "start": "snowmpm.compiler.runtime", "campaign": "snowmpm.campaigns.launch"}

__all__ = ["Run", "Simulation", "campaign", "load_scene", "open_run", "register", "run", "start"]


def run(scene: "Scene", out_dir: "PathLike", progress: "Callable[[Progress], object] | bool | None" = None,
        resume: bool = False, overwrite: "bool | None" = None,
        approve: "Callable[[Simulation], object] | None" = None, accept_plugin: bool = False) -> "Run":
    """Simulate a scene and write its run folder; -> `snowmpm.io.Run`. See `snowmpm.running.loop.run`.

    progress: called with a `Progress` regularly; by default, or with True, a notebook shows a bar, which False leaves
        out.
    """
    compute = importlib.import_module("snowmpm.running.loop").run
    bar = progress in (None, True) and notebook.in_notebook()
    with notebook.run_bar(scene.name) if bar else nullcontext(progress if callable(progress) else None) as told:
        return compute(scene, out_dir, told, resume, overwrite, approve, accept_plugin)


def open_run(path: "PathLike") -> "Run":
    """Open a run, its folder or its run file, also while it goes on; -> `snowmpm.io.Run`.

    Frames, maps and terrain are read when they are asked for; `refresh()` looks for new frames. Starts no compiler.
    Raises InputError for what is no run.
    """
    return importlib.import_module("snowmpm.io").Run(path)


def __getattr__(name: str) -> object:
    if name in _HOMES:
        if name not in ("Run", "register"):
            importlib.import_module("snowmpm.compiler")  # before the laws are read, which then takes less time
        return getattr(importlib.import_module(_HOMES[name]), name)
    raise AttributeError(f"module 'snowmpm' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted([*globals(), *_HOMES])
