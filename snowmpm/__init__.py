"""snowmpm: snow and avalanche mechanics at finite strain.

    import snowmpm
    scene = snowmpm.load_scene("slab_release_2d", {"solver.dx": 0.05})
    run = snowmpm.run(scene, "runs/slab")

Importing the package starts nothing: names below are loaded when first used.
"""

import importlib
import os

__version__ = "0.1.0"

os.environ.setdefault("ENABLE_TAICHI_HEADER_PRINT", "0")  # a library does not print when it is imported

_HOMES = {"load_scene": "snowmpm.scenes", "Simulation": "snowmpm.simulation", "Run": "snowmpm.io",
          "start": "snowmpm.runtime"}

__all__ = ["Run", "Simulation", "load_scene", "run", "start"]


def run(scene, out_dir, progress=None, resume=False, overwrite=True):
    """Simulate a scene and write its run folder; -> `snowmpm.io.Run`. See `snowmpm.loop.run`."""
    return importlib.import_module("snowmpm.loop").run(scene, out_dir, progress, resume, overwrite)


def __getattr__(name):
    if name in _HOMES:
        return getattr(importlib.import_module(_HOMES[name]), name)
    raise AttributeError(f"module 'snowmpm' has no attribute {name!r}")


def __dir__():
    return sorted([*globals(), *_HOMES])
