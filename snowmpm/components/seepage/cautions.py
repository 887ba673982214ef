"""Rules: steps of seepage, and water that is too soft."""

import numpy as np

from snowmpm.advice.cautions.caution import Caution, beyond, rule, worded
from snowmpm.water.squeezing import ENOUGH, SQUEEZED


@rule("sph")
def steps_and_stiffness(facts):
    """Steps of seepage that cross too much of a spacing; water so soft that it is squeezed, or stiffer than helps."""
    water = facts.scene.water
    if water is None or water.scheme != "seepage":
        return
    cfl = facts.solver.limits.cfl
    if border := beyond("long_seepage_step", "K_w 1e6", cfl):
        yield worded(border, "solver.cfl", cfl)
    height = float(np.ptp(facts.model.population.positions[:, -1]))
    pressure = max(water.density * facts.gravity * height, 1e-300)
    enough = float(f"{ENOUGH * pressure:.2g}")
    if pressure / water.bulk_modulus > SQUEEZED:
        yield Caution("", "water.bulk_modulus", f"water of this stiffness is squeezed by"
                      f" {100.0 * pressure / water.bulk_modulus:.2g} % under its own weight, {pressure:.3g} Pa",
                      f"water.bulk_modulus = {enough:g}")
