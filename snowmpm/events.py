"""What happens to bodies while a simulation runs: saw cut, load, removal.

Each event has `apply(simulation)`, called before every step until it is `done`; the `load` that it puts on the snow
now, or None; and its progress as `state()` and `restore(state)`.
"""

import numpy as np

from snowmpm.errors import InputError


class Event:
    """What all events have in common: one of a scene's events table and the index of the body that it names."""

    load = None
    """(centre (dim,) [m], radius [m], acceleration (dim,) [m/s2])"""

    def __init__(self, spec, body):
        self.done = False
        self._spec, self._body = spec, body

    def state(self):
        """Progress, as numbers by name."""
        return {"done": self.done}

    def restore(self, state):
        """Take over what `state()` gave."""
        self.done = state["done"]


class Cut(Event):
    """A saw drawn through a body. Seen from above, particles of the body within half the width of the path that the
    saw passes lose their strength and their stress: the law's `severed_state()`; their mass stays."""

    def __init__(self, spec, body, width):
        super().__init__(spec, body)
        self._half_width = 0.5 * width
        self._path = np.asarray(spec.path, float)[:, :-1]
        self._at = np.r_[0.0, np.cumsum(np.linalg.norm(np.diff(self._path, axis=0), axis=1))]
        self._cut_to = -np.inf

    def state(self):
        return {**super().state(), "cut_to": self._cut_to}

    def restore(self, state):
        super().restore(state)
        self._cut_to = state["cut_to"]

    def apply(self, simulation):
        if simulation.time < self._spec.start:
            return
        length, speed = self._at[-1], self._spec.speed
        reached = length if speed is None else min(length, (simulation.time - self._spec.start) * speed)
        # Half a cell at a time: the grid sees no finer.
        if reached < length and reached < self._cut_to + 0.5 * simulation.scene.solver.dx:
            return
        law = simulation.law_of_body(self._body)
        if law.severed_state() is None:
            raise InputError.at("events.body", self._spec.body, f"{law.kind} has no severed state, so it cannot be cut")
        simulation.solver.particles.sever(self._piece(max(self._cut_to, 0.0), reached), self._half_width,
                                simulation.numbers_of_body(self._body), law.severed_state())
        self._cut_to = reached
        self.done = reached >= length

    def _piece(self, start, end):
        """Corners of the path between two distances along it [m], (k, dim - 1)."""
        inside = self._at[(self._at > start) & (self._at < end)]
        along = np.r_[start, inside, end]
        return np.stack([np.interp(along, self._at, column) for column in self._path.T], axis=1)


class Load(Event):
    """A force on the snow within `radius` of a point, such as a skier: the same acceleration for all of it, so that
    the total is the force asked for when it sets in."""

    def state(self):
        return {**super().state(), "load": self.load}

    def restore(self, state):
        super().restore(state)
        self.load = state["load"]

    def apply(self, simulation):
        spec = self._spec
        stop = np.inf if spec.stop is None else spec.stop
        if self.load is None and spec.start <= simulation.time < stop:
            fields = simulation.particles
            near = np.linalg.norm(fields["position"] - np.asarray(spec.centre), axis=1) < spec.radius
            mass = float(fields["mass"][near].sum())
            if not (near & (fields["body"] == self._body)).any():
                nothing = f"no snow of {spec.body} within {spec.radius} m"
                raise InputError.at("events.centre", list(spec.centre), nothing)
            self.load = spec.centre, spec.radius, np.asarray(spec.force) / mass
            simulation.follow_loads()
        elif simulation.time >= stop:
            self.load, self.done = None, True
            simulation.follow_loads()


class Remove(Event):
    """A body taken away at once; its particles count as removed."""

    def apply(self, simulation):
        if simulation.time >= self._spec.start:
            simulation.solver.remove(simulation.particles["body"] == self._body)
            self.done = True


def make_event(spec, body, dx):
    """Event of a scene's events table; body: index of the body that it names."""
    if spec.kind == "cut":
        return Cut(spec, body, spec.width or 2.0 * dx)
    return {"load": Load, "remove": Remove}[spec.kind](spec, body)
