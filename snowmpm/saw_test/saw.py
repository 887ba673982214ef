"""The saw: it cuts the weak layer as it advances (`saw_test.weak_layer`)."""


class Saw:
    """An event of the run (`snowmpm.running.events`): what lies of the layer below the saw's position
    x is cut.

    length, speed, start: total cut [m], [m/s], [s]; it begins at x = notch.
    """

    load = None

    def __init__(self, layer, body, notch, length, speed, start):
        """layer: `weak_layer.WeakLayer`; body: its number."""
        self.done, self._layer = length <= notch, layer
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
        if reached < self._length and reached < self.cut_to + self._layer.stroke:
            return
        self._layer.cut(simulation, self._body, reached)
        self.cut_to, self.done = reached, reached >= self._length
