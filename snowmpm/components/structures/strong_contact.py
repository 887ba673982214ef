"""Contact of the nodes with structures whose answer is part of the step: snow and structure go the same way.

In each round the nodes are what they were before these structures, which act on them with the velocities sought, and
give the impulse of that to the rods; the rods go through the step with other mean velocities, until they are those
sought (`.quasi_newton`). Places are those of the begin of the step, as they are for all contact.
"""

import numpy as np

from snowmpm.compiler import ti
from snowmpm.compiler.runtime import DTYPES
from snowmpm.mpm.kernel_api import block_nodes, copy_kernel, node_size


class StrongContact:
    """The rounds of a step. solver: `mpm.solver.MpmSolver`; rods: `.rods.Rods`, some of them strong."""

    def __init__(self, solver, rods):
        self._solver, self._rods, self._kept = solver, rods, None
        self._numbers = rods.segments_of_strong
        self._surfaces = [solver.obstacles[number] for number in self._numbers]
        self._of_node = node_size(solver.grid.flip), DTYPES[solver.precision][0]

    def apply(self, dt):
        """Contact of all surfaces in a step of dt [s]."""
        solver, rods, grid = self._solver, self._rods, self._solver.grid
        grid.apply_contact(solver.dx, but=self._surfaces)
        acting = [surface for surface in self._surfaces if grid.acts(surface)]
        if not acting:
            return
        copy, n = copy_kernel(*self._of_node), grid.contact.n * block_nodes(grid.dim)
        if self._kept is None or self._kept.shape[0] < n:
            self._kept = ti.ndarray(ti.types.vector(*self._of_node), (int(1.25 * n) + 64,))
        copy(grid.nodes, grid.contact_offset, self._kept, 0, n)
        before, totals = self._given(), [surface.total.copy() for surface in acting]

        def answer(x):
            copy(self._kept, 0, grid.nodes, grid.contact_offset, n)
            rods.meet(x)
            for surface, total in zip(acting, totals, strict=True):
                surface.total[:] = total
                surface.carry(solver.time, solver.frame.origin, solver.dx)
                surface.apply_contact(grid, solver.dx)
            return rods.answer(dt, solver.gravity, self._given() - before)

        rods.agree(answer, dt, solver.gravity)

    def _given(self):
        """What the snow gave all obstacles so far, (obstacles, ...); 0 for those without an answer."""
        rows = np.zeros((len(self._solver.obstacles), self._solver.dim + (1 if self._solver.dim == 2 else 3) + 1))
        for number, surface in zip(self._numbers, self._surfaces, strict=True):
            rows[number] = surface.given_to_solid(self._solver.dx)
        return rows
