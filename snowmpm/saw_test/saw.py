"""The saw: it removes the weak layer as it advances; of an interface it takes the stress."""

STROKE = 0.5
"""Advance of the saw at a time [cells]: the grid resolves no less. Of an interface it is a point."""


class Saw:
    """An event of the run (`snowmpm.running.events`): all particles of a body with x below the saw's position are
    removed.

    length, speed, start: total cut [m], [m/s], [s]; it begins at x = notch.
    """

    load = None

    def __init__(self, body, notch, length, speed, start, points=None):
        """points: a cell and direction, of a body that is an interface: they stay, without stress."""
        self.done, self._opens = length <= notch, points is not None
        self._stroke = STROKE if points is None else 1.0 / points
        self._body, self._notch, self._length, self._speed, self._start = body, notch, length, speed, start
        self.cut_to = notch
        """x up to which the weak layer is gone [m]."""

    def at(self, time):
        """Position x [m] of the saw at a time [s]."""
        return float(min(max(self._notch + (time - self._start) * self._speed, self._notch), self._length))

    def to_come(self, time):
        """Whether the saw still cuts after `time` [s]."""
        return not self.done

    def state(self):
        return {"done": self.done, "cut_to": self.cut_to}

    def restore(self, state):
        self.done, self.cut_to = state["done"], state["cut_to"]

    def apply(self, simulation):
        reached = self.at(simulation.time)
        if reached < self._length and reached < self.cut_to + self._stroke * simulation.scene.solver.dx:
            return
        if self._opens:
            simulation.solver.open(simulation.numbers_of_body(self._body), reached,
                                   simulation.law_of_body(self._body).severed_state())
        else:
            fields = simulation.particles
            gone = (fields["body"] == self._body) & (fields["position"][:, 0] < reached)
            if gone.any():
                simulation.solver.remove(gone)
        self.cut_to, self.done = reached, reached >= self._length
