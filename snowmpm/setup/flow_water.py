"""From the table `[water]` of a scene to the water in its depth-averaged flow."""

import numpy as np

from snowmpm.errors import InputError
from snowmpm.setup.forests import inside_region
from snowmpm.setup.pore_water import porosities
from snowmpm.water.flow_water import FlowWater


def flow_water(model):
    """`FlowWater` of a scene. Raises InputError for a material that cannot hold water, snow that floats, and a drain
    off the terrain."""
    spec, scene = model.scene.water, model.scene
    porosity = porosities(scene)
    dry = np.array([law.density for law in scene.materials.values()])
    water = FlowWater(spec.density * spec.level * porosity, 1.0 - porosity, dry, spec.density, spec.level,
                      spec.consolidation, spec.excess, spec.layers, _drained(model), -float(model.first_gravity[2]))
    for name, rho in zip(scene.materials, water.buoyant, strict=True):
        if not rho > 0.0:
            raise InputError.at("water.level", spec.level, f"lets the snow of materials.{name} float: its weight under"
                                f" water is {rho:.4g} kg/m3; without friction at the ground leave water out",
                                scene.source)
    return water


def _drained(model):
    """Function (plan places (n, 2) [m]) -> whether the ground lets water out there (n,)."""
    spec, scene, surface = model.scene.water, model.scene, model.surface

    def drained(plan):
        found = np.full(len(plan), spec.ground == "drained")
        for i, region in enumerate(spec.drains):
            try:
                found |= inside_region(region, surface, plan, scene.base_dir, f"water.drains.{i}")
            except InputError as error:
                raise InputError(f"{scene.source}: {error}") from None
        return found

    return drained
