"""The ground: surfaces from planes, profiles, meshes and rasters, and their distance field."""

from snowmpm.terrain.distance import DistanceField
from snowmpm.terrain.load import load_terrain
from snowmpm.terrain.surface import TerrainSurface

__all__ = ["DistanceField", "TerrainSurface", "load_terrain"]
