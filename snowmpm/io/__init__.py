"""Run files: `RunWriter` writes them, `Run` reads them. Needs neither Taichi nor a solver."""

from snowmpm.io.background import Background
from snowmpm.io.folder_lock import FolderLock
from snowmpm.io.ground_maps import Map, Terrain
from snowmpm.io.obstacles import Obstacle
from snowmpm.io.reader import Frame, Run
from snowmpm.io.writer import RunWriter

__all__ = ["Background", "FolderLock", "Frame", "Map", "Obstacle", "Run", "RunWriter", "Terrain"]
