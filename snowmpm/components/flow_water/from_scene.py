"""From the table `[water]` of a scene to the water in its depth-averaged flow."""

from dataclasses import replace

import numpy as np

from snowmpm.components.flow_water.one_phase import FlowWater
from snowmpm.components.flow_water.two_phase import TwoPhaseWater
from snowmpm.errors import InputError
from snowmpm.particles.population import Population
from snowmpm.seeding.regions import inside_region
from snowmpm.water.drag import Anderson, Darcy, DarcyOfPorosity
from snowmpm.water.porosity import porosity_of_grains, porosity_of_snow


def mixed_water(model):
    """`TwoPhaseWater` of a scene. Raises InputError for grains that float, and a drain off the terrain."""
    spec, scene = model.scene.water, model.scene
    if not spec.grain_density > spec.density:
        raise InputError.at("water.grain_density", spec.grain_density, f"must be above water.density ="
                            f" {spec.density:g}: grains that float part from the water; for ice take scheme ="
                            ' "one_phase" with a level below 1', scene.source)
    return TwoPhaseWater.of(porosity_of_grains(scene), spec.grain_density, _drag(spec, -float(model.first_gravity[2])),
                            density=spec.density, consolidation=spec.consolidation, excess=spec.excess,
                            layers=spec.layers, drained=_drained(model), gravity=-float(model.first_gravity[2]))


def two_phases(scene, body, part):
    """`Population` of the grains of a body, then of the water in its pores, where each has columns of its own."""
    if scene.water.scheme != "two_phase":
        return part
    count = len(scene.materials)
    porosity = porosity_of_grains(scene)[part.material]
    parts = [replace(part, volumes=share * part.volumes, material=part.material + k * count)
             for k, share in enumerate((1.0 - porosity, porosity))]
    return Population.joined(parts)


def laws(model):
    """Laws of the columns of water, one for each material."""
    return model.laws if model.scene.water.scheme == "two_phase" else []


def _drag(spec, gravity):
    drag = spec.drag
    if drag.law == "anderson":
        return Anderson((spec.grain_density - spec.density) * gravity, drag.terminal_velocity, drag.power)
    if isinstance(drag.permeability, float):
        return Darcy(drag.permeability / drag.viscosity)
    return DarcyOfPorosity(lambda n: drag.permeability.of(n) / drag.viscosity)


def flow_water(model):
    """`FlowWater` of a scene, or `TwoPhaseWater`. Raises InputError for a material that cannot hold water, snow that
    floats, and a drain off the terrain."""
    spec, scene = model.scene.water, model.scene
    if spec.scheme == "two_phase":
        return mixed_water(model)
    porosity = porosity_of_snow(scene)
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
