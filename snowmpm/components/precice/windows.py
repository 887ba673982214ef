"""Steps of a simulation in the time windows of another program (`.exchange`).

Where windows are repeated until both programs agree, a step of the simulation is a window: nothing is seen of what was
computed before they did. The state at its begin is that of a checkpoint.
"""

from typing import Any

from snowmpm.components.precice.from_scene import exchange, path_of
from snowmpm.errors import InputError, SimulationError
from snowmpm.stepping.component import Adapter

SAME = 1e-6
"""Share of a window below which two times are one."""


def adapter(model: Any) -> Adapter:
    """An `Adapter` without a part in the steps of the snow."""
    return Windows()


class Windows(Adapter):
    """Structures of another program: `rods.Rods` moves them, `Coupling` asks for the steps."""

    name = "precice"


def steps(simulation: Any) -> "Coupling":
    """`Coupling` of a `Simulation`."""
    return Coupling(simulation, exchange(simulation.model), path_of(simulation.scene))


class Coupling:
    """The steps of a `Simulation`, and the `.exchange.Exchange` that it takes part in."""

    def __init__(self, simulation: Any, exchange: Any, path: Any) -> None:
        """path: of the configuration of preCICE."""
        self._simulation, self._exchange, self._path = simulation, exchange, path

    def step(self, until: float | None) -> None:
        """A step, no longer than to `until` [s] and to the end of the window; or a window. SimulationError: there is no
        window any more; InputError: `until` lies within one that is repeated."""
        simulation, exchange = self._simulation, self._exchange
        if not exchange.met:
            exchange.connect(self._path, simulation.time)
        elif not exchange.open:
            raise SimulationError(f"the coupling by preCICE ended at t = {simulation.time:.6g} s")
        end = exchange.end
        for known in (until, exchange.windows.end):
            if known is not None and abs(end - known) <= SAME * (end - simulation.time):
                end = known
        if exchange.windows.implicit:
            self._window(until, end)
            return
        simulation.advance(end if until is None else min(until, end))
        if not exchange.windows.size or simulation.time >= end:
            exchange.finish(simulation.time, simulation.dt)
            self._go_on()

    def _window(self, until, end):
        """Compute a window to its end [s] until both programs agree."""
        simulation, exchange = self._simulation, self._exchange
        begin = simulation.time
        if until is not None and until < end:
            raise InputError(f"until = {until:g} s lies in a time window of preCICE, from {begin:g} to {end:g} s")
        kept, rounds, again = simulation.state(), 0, True
        while again:
            while simulation.time < end:
                simulation.advance(end)
            rounds, again = rounds + 1, exchange.finish(end, end - begin)
            if again:
                simulation.restore(kept)
                exchange.begin(begin)
        rods = simulation.solver.adapters["structures"].rods
        rods.rounds += rounds
        rods.unsettled += rounds == exchange.windows.rounds
        simulation.dt, simulation.dt_cause = end - begin, "window"
        self._go_on()

    def _go_on(self):
        if self._exchange.open:
            self._exchange.begin(self._simulation.time)
