"""Water in the pores of explicit MPM."""

from snowmpm.components.pore_water.from_scene import filled, parts
from snowmpm.components.pore_water.step import PoreWater
from snowmpm.schemes import TRANSFERS

SHARE = {("affine", True): 0.31, ("affine", False): 0.62, ("shape", True): 0.47, ("shape", False): 0.94}
"""s_0 of `step` by gradient and by whether the transfer hands C on: with C, grains are stable to (dt w)² =
4, without to 2 (`stepping.time_step`), of which water takes 0.8 of what a step leaves; with "shape", the pressure moves
a grain up to 1.5 times further."""


def adapter(model):
    """`PoreWater` of a `Model`."""
    spec, solver = model.scene.water, model.scene.solver
    share = SHARE[solver.gradient, TRANSFERS[solver.transfer].affine] if spec.split == "semi_implicit" else 0.0
    fluid, permeability, outlets = parts(model)
    return filled(model, PoreWater(fluid, permeability, outlets, share, shorten=solver.cfl is None))
