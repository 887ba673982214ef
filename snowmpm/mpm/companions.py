"""What only some scenes have in a step of `MpmSolver`, beside scatter, grid and gather: layers thinner than a cell
(`interface_layer`)."""

from snowmpm.compiler import runtime
from snowmpm.mpm.contact.hidden_nodes import hiding_kernels
from snowmpm.mpm.interface_layer import InterfaceLayer


class Companions:
    """Those of a solver, each None where the scene has none: interface."""

    def __init__(self, solver, population, laws, serial):
        """solver: `MpmSolver` with its particles and grid; serial: see `compiler.parallel.runs_serially`.

        Raises InputError where a companion does not go with the solver's choices.
        """
        self._solver = solver
        self.interface = None
        if population.interface is not None:
            self.interface = InterfaceLayer(solver, population, laws, serial)
            solver.grid.hiding = hiding_kernels(runtime.DTYPES[solver.precision][0], serial)

    def before_scatter(self, pushed):
        """Of a step whose forces act for `pushed` [s]."""
        if self.interface:
            self._solver.add_impulse(self._solver.damping_factor * self.interface.impulse(pushed))

    def shorten(self, dt, critical, elastic):
        """dt [s] where companions swing; critical, elastic: the cfl at which waves grow, and that of dt."""
        return self.interface.shorten(dt, critical, elastic) if self.interface else dt
