"""From the table `[water]` of a scene to the water in its depth-averaged flow."""

from dataclasses import replace

import numpy as np

from snowmpm.errors import InputError
from snowmpm.particles.population import Population
from snowmpm.seeding.regions import inside_region
from snowmpm.setup.pore_water import porosities
from snowmpm.water.drag import Anderson, Darcy, DarcyOfPorosity
from snowmpm.water.flow_water import FlowWater
from snowmpm.water.two_phase import TwoPhaseWater


def mixed_water(model):
    """`TwoPhaseWater` of a scene. Raises InputError for grains that float, and a drain off the terrain."""
    spec, scene = model.scene.water, model.scene
    if not spec.grain_density > spec.density:
        raise InputError.at("water.grain_density", spec.grain_density, f"must be above water.density ="
                            f" {spec.density:g}: grains that float part from the water; for ice take scheme ="
                            ' "one_phase" with a level below 1', scene.source)
    return TwoPhaseWater.of(grain_shares(scene), spec.grain_density, _drag(spec, -float(model.first_gravity[2])),
                            density=spec.density, consolidation=spec.consolidation, excess=spec.excess,
                            layers=spec.layers, drained=_drained(model), gravity=-float(model.first_gravity[2]))


def grain_shares(scene):
    """Porosity of each material of a scene with two phases."""
    found = []
    for name, law in scene.materials.items():
        porosity = 1.0 - law.density / scene.water.grain_density
        if not porosity > 0.0:
            raise InputError.at(f"materials.{name}.density", law.density, "holds no water: must be below"
                                f" water.grain_density = {scene.water.grain_density:g}", scene.source)
        found.append(porosity)
    return np.array(found)


def two_phases(scene, part):
    """`Population` of the grains of a body, then of the water in its pores."""
    count = len(scene.materials)
    porosity = grain_shares(scene)[part.material]
    parts = [replace(part, volumes=share * part.volumes, material=part.material + k * count)
             for k, share in enumerate((1.0 - porosity, porosity))]
    return Population.joined(parts)


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
