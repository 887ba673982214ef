"""Water in the pores of implicit MPM, whose pressure is among the unknowns of a step."""

from snowmpm.components.pore_water.coupled_step import CoupledStep
from snowmpm.components.pore_water.from_scene import filled, parts
from snowmpm.components.pore_water.solved import Coupling, SolvedWater


def adapter(model):
    """`SolvedWater` of a `Model`."""
    spec = model.scene.water
    coupling = Coupling(spec.split, spec.alpha, spec.tolerance, spec.iterations)
    fluid, permeability, outlets = parts(model)
    return filled(model, SolvedWater(fluid, permeability, outlets, coupling, CoupledStep))
