"""Structures in the steps of a method whose contact tells what the snow gives obstacles."""

from snowmpm.components.structures.from_scene import rods
from snowmpm.stepping.component import Adapter


def adapter(model):
    """`InSnow` of a `Model`."""
    return InSnow(rods(model))


class InSnow(Adapter):
    """The `Rods` among the obstacles of a solver. While the snow settles, they are held."""

    name = "structures"

    def __init__(self, rods):
        self.rods = rods

    def begin(self, solver):
        """Time zero."""
        self._solver = solver
        self.rods.begin()

    def end_step(self, dt):
        """Give them what the snow gave in the step, and move them."""
        solver = self._solver
        if solver.damping_factor == 1.0:
            self.rods.advance(solver.time, dt, solver.gravity, solver.obstacle_totals)

    def restart(self):
        """Time zero is now."""
        self.rods.begin()

    def work(self):
        """`Rods.workload` of a step."""
        return self.rods.workload(self._solver.expected_dt()[0])

    def row(self):
        """`Rods.row`."""
        return self.rods.row(self._solver.gravity)

    def units(self):
        """`Rods.units`."""
        return self.rods.units()

    def state(self):
        """`Rods.state`."""
        return self.rods.state()

    def restore(self, state):
        """Take over what `state()` gave."""
        self.rods.restore(state)
