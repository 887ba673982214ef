"""A sample of snow: an image of voxels, and which of them are ice."""

from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace

import numpy as np

from snowmpm import memory
from snowmpm.errors import InputError
from snowmpm.micro import pores
from snowmpm.seeding.voxels import read_voxels

BYTES = 28
"""Memory of a voxel while pores are told apart: their labels, the names of these, what leads through."""


@dataclass(frozen=True)
class Sample:
    """ice (nx, ny, nz): True where there is ice; voxel_size [m]; name."""

    ice: np.ndarray
    voxel_size: float
    name: str = "sample"

    @classmethod
    def read(cls, path, voxel_size, phase=1, counts=None):
        """From a file of `seeding.voxels.read_voxels` (.npy, .npz, .tif, .mhd, .mha, .raw with its `counts`); phase:
        value of ice.

        Memory for the geometry is asked for before. InputError: unreadable, too large, no three axes, no ice or nothing
        else, a voxel size that is no length.
        """
        path = Path(path)
        if not (np.isfinite(voxel_size) and 0.0 < voxel_size < 1.0):
            raise InputError.at("--voxel-size", voxel_size, "must be a length in metres, > 0 and < 1")
        spec = SimpleNamespace(file=path, voxel_size=voxel_size, counts=counts, phase=phase)
        ice = read_voxels(spec, 3, Path.cwd(), "SAMPLE") == phase
        size = " x ".join(map(str, ice.shape))
        memory.require(BYTES * float(ice.size), f"{path}: {size} voxels", pores.SMALLER)
        if ice.all() or not ice.any():
            there = "every" if ice.all() else "no"
            raise InputError(f"{path}: {there} voxel has the value {phase} of --phase: must be ice and pores")
        if min(ice.shape) < 4:
            raise InputError(f"{path}: {size} voxels: must be at least 4 along each axis")
        return cls(ice, float(voxel_size), path.stem)

    def numbers(self):
        """Facts of the geometry by name, in SI units; grains: number of equivalent spheres with the ice's volume."""
        surface = pores.specific_surface(self.ice, self.voxel_size)
        solid = float(self.ice.mean())
        radius = pores.equivalent_radius(self.ice, self.voxel_size)
        grains = solid * self.ice.size * self.voxel_size**3 / (4.0 / 3.0 * np.pi * radius**3)
        through = [float(pores.connected_pores(~self.ice, axis).mean()) for axis in range(3)]
        return {"voxels": list(self.ice.shape), "size": [n * self.voxel_size for n in self.ice.shape],
                "density": pores.ICE_DENSITY * solid, "porosity": 1.0 - solid, "connected_porosity": through,
                "surface_per_volume": surface, "surface_per_mass": surface / (pores.ICE_DENSITY * solid),
                "equivalent_radius": radius, "grains": grains}
