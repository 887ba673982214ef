"""Rules: water with a velocity of its own that is stiffer than flow needs, or too soft."""

import numpy as np

from snowmpm.advice.cautions.caution import Caution, rule
from snowmpm.water.squeezing import ENOUGH, SQUEEZED

STIFFER = 3.0
"""How much shorter than the skeleton's its steps may be."""


@rule("mpm")
def own_velocity(facts):
    """Water with a velocity of its own that is stiffer than flow needs, or so soft that it is squeezed."""
    water, solver = facts.scene.water, facts.solver
    if water is None or water.scheme != "v_w":
        return
    x = facts.model.population.positions[:, -1]
    pressure = max(water.pressure, water.density * facts.gravity * float(np.ptp(x)), 1e-300)
    squeezed, enough = pressure / water.bulk_modulus, float(f"{ENOUGH * pressure:.2g}")
    if squeezed > SQUEEZED:
        yield Caution("", "water.bulk_modulus", f"water of this stiffness is squeezed by {100.0 * squeezed:.2g} % under"
                      f" its own weight, {pressure:.3g} Pa", f"water.bulk_modulus = {enough:g}")
    factor = solver.critical_elastic_dt() * solver.limits.cfl / solver.limits.critical_cfl / solver.stable_dt()[0]
    shorter = solver.adapters.wave_speed / solver.materials.fastest_wave
    if factor > STIFFER and water.bulk_modulus > 2.0 * enough and shorter > STIFFER:
        yield Caution("undrained_step", "water.bulk_modulus", f"steps follow waves in undrained snow and are"
                      f" {factor:.3g} times shorter than the skeleton needs",
                      f"water.bulk_modulus = {enough:g} squeezes the water by 1 % at most")
