"""Run files: `RunWriter` writes them, `Run` reads them. Needs neither Taichi nor a solver."""

from snowmpm.io.reader import Frame, Map, Run, Terrain
from snowmpm.io.writer import RunWriter

__all__ = ["Frame", "Map", "Run", "RunWriter", "Terrain"]
