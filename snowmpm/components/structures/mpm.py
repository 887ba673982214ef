"""Structures in explicit MPM, where they may answer within the step."""

from snowmpm.components.structures.acting import InSnow
from snowmpm.components.structures.from_scene import rods
from snowmpm.components.structures.strong_contact import StrongContact


def adapter(model):
    """`OnNodes` of a `Model`."""
    return OnNodes(rods(model))


class OnNodes(InSnow):
    """The `Rods` among the obstacles of an `MpmSolver`."""

    def begin(self, solver):
        """Time zero."""
        super().begin(solver)
        self._answered = StrongContact(solver, self.rods) if self.rods.strong else None

    def meet_surfaces(self, dt):
        """Contact of the nodes, of structures that answer within the step with the velocity that they then have."""
        if self._answered is None or self._solver.damping_factor < 1.0:
            return False
        self._answered.apply(dt)
        return True
