"""Scenes of snowmpm: the schema of scene files, their loader, and the library that comes with the program."""

if __name__ != "snowmpm.scenes":
    raise ImportError("import this package as snowmpm.scenes")

from snowmpm.scenes.library import library
from snowmpm.scenes.loader import load_scene
from snowmpm.scenes.schema import Scene

__all__ = ["Scene", "library", "load_scene"]
