"""Porosity of the materials of a scene, from their density and that of their grains."""

import numpy as np

from snowmpm.errors import InputError
from snowmpm.water.permeability import ICE_DENSITY


def porosity_of_snow(scene):
    """Porosity of each material at J = 1, given by the table `[water]` or that of ice. Raises InputError for a material
    that cannot hold water."""
    spec, found = scene.water, []
    for name, law in scene.materials.items():
        own = 1.0 - law.density / ICE_DENSITY if spec.porosity is None else spec.porosity
        if not own > 0.0:
            raise InputError.at(f"materials.{name}.density", law.density, f"holds no water: must be below"
                                f" {ICE_DENSITY:g} (ice), or give water.porosity", scene.source)
        found.append(own)
    return np.array(found)


def porosity_of_grains(scene):
    """Porosity of each material whose grains have the density that the table `[water]` gives. Raises InputError for a
    material that cannot hold water."""
    found = []
    for name, law in scene.materials.items():
        porosity = 1.0 - law.density / scene.water.grain_density
        if not porosity > 0.0:
            raise InputError.at(f"materials.{name}.density", law.density, "holds no water: must be below"
                                f" water.grain_density = {scene.water.grain_density:g}", scene.source)
        found.append(porosity)
    return np.array(found)
