"""Water that particles carry in their column "water": what all ways to move it share."""

from typing import ClassVar

from snowmpm.stepping.component import Adapter
from snowmpm.water.budget import Budget
from snowmpm.water.particle_kernels import MASS, N_WATER


class WaterAdapter(Adapter):
    """density: of water [kg/m3]. budget: `Budget`; rain: {source: (rate [kg/m2/s], plan (k, dim - 1) [m] -> (k,)
    bool)} that falls now."""

    columns: ClassVar = {"water": N_WATER}
    mass_column = "water"
    density: float

    def __init__(self):
        self.budget, self.rain = Budget(), {}

    def begin(self, solver):
        """Take the solver, at time zero."""
        self._solver = solver
        solver.particles.constants["water_density"] = self.density

    def held(self):
        """Water in the particles now [kg]."""
        particles = self._solver.particles
        return float(particles.column("volume")[:, 0] @ particles.column("water")[:, MASS])

    def row(self):
        """Mass of water [kg] and what is left open of its balance."""
        budget, now, removed = self.budget, self.held(), self._solver.particles.removed["carried"]
        return {"water_mass": now, "drained_water": budget.drained, "added_water": budget.added,
                "removed_water": removed, "water_residual": budget.residual(now, removed)}

    def given(self, lift):
        """Work of the water [J], and energy that it brought; lift [J/kg]: as of what is removed."""
        budget = self.budget
        return {"water_work": budget.work + budget.carried_energy + budget.carried_mass * lift}

    def state(self):
        """All that a bitwise continuation needs beside the particles, by name."""
        return {"budget": self.budget.state()}

    def restore(self, state):
        """Take over what `state()` gave."""
        self.budget = Budget(**state["budget"])
