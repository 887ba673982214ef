"""Steps of particles with water in their pores: `implicit.step_solver` with the pressure among the unknowns."""

import numpy as np

from snowmpm.components.pore_water.at_once import AtOnce, solve_at_once, solve_in_turn
from snowmpm.components.pore_water.pores import Pores
from snowmpm.components.pore_water.solved import Place
from snowmpm.errors import SimulationError
from snowmpm.implicit.kernel_api import SMALLEST_PART, Balance, Linear, NotConverged, StepResult, StepSolver


class CoupledStep(StepSolver):
    """As the `StepSolver` of a solver; water: `solved.SolvedWater` in the pores."""

    def __init__(self, solver, water):
        super().__init__(solver.step_solver.grid, solver.step_solver.rules, solver.step_solver.materials)
        self._solver, self._water = solver, water
        law_stiffness = self.materials.density * self.materials.wave_speed**2
        self._unit = float(np.max(law_stiffness)) / self.grid.dx

    def to_balance(self, matter, body, dt):
        """Balance of the skeleton while water flows for dt [s], in as many parts of it as it takes."""
        passed = StepResult(*np.zeros((2, matter.cells.shape[1])))
        done, part = 0.0, 1.0
        while done < 1.0:
            part = min(part, 1.0 - done)
            try:
                self._part(matter, body, part * dt, passed)
            except NotConverged as error:
                part *= 0.5
                if part < SMALLEST_PART:
                    raise SimulationError(self._why(error, "its time")) from error
                continue
            done += part
            part *= 2.0
        return passed

    def _part(self, matter, body, dt, passed):
        mesh, held = self.mesh(matter)
        balance = (mesh, held, matter, self.materials, body, self.grid.dx, dt)
        solved = self._solved(matter, balance, dt, np.zeros(held.T.shape[1]))
        matter.velocity[:] = 0.0
        matter.affine[:] = 0.0
        matter.cells += mesh.W @ solved.trial.u / self.grid.dx
        passed.force = self._force(held, solved.trial)
        passed.impulse += dt * passed.force
        self._book(passed, matter, solved)

    def _solved(self, matter, setting, dt, start):
        """`Solved` of the equations `Balance(*setting)` with the flow for dt [s]."""
        mesh, held, water, rules = setting[0], setting[1], self._water, self.rules
        cells, codes = water.cells(np.floor(matter.cells).astype(np.int64), self._solver.frame, self._solver.time)
        place = Place(self.grid.dx, self.grid.origin, self._solver.gravity)
        pores = Pores(matter, cells, codes, water, place, dt)
        if water.coupling.way == "monolithic":
            balance = AtOnce(pores, self._unit, *setting)
            linear = Linear(balance.held.T, mesh.dim, "direct")
            solved, pressure, passes = solve_at_once(balance, linear, rules, start)
        else:
            linear = Linear(held.T, mesh.dim, rules.linear)
            solved, pressure, passes = solve_in_turn(Balance(*setting), linear, rules, water.coupling, pores, start)
        water.passes, solved.flow = passes, (pores, pressure)
        return solved

    def _book(self, passed, matter, solved):
        """The same, and what the water did; particles have moved."""
        super()._book(passed, matter, solved)
        self._water.take(matter, *solved.flow)
