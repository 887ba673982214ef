"""What all events of a run have."""

from typing import Any


class Event:
    """Base of all events: an entry of the scene's events table and the index of the body that it names, if any."""

    load: tuple[Any, Any, Any] | None = None
    """(centre (dim,) [m], radius [m], acceleration (dim,) [m/s2])"""

    def __init__(self, spec, body, dx=0.0):
        """spec: the table; body: number of the body that it names, or None; dx [m]."""
        self.done = False
        self._spec, self._body = spec, body

    def to_come(self, time):
        """Whether part of the event is still to come after `time` [s]."""
        return not self.done

    def state(self):
        """Progress, as numbers by name."""
        return {"done": self.done}

    def restore(self, state):
        """Restore the result of `state()`."""
        self.done = state["done"]
