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
    saw has passed lose their strength and their stress: the law's `severed_state()`; their mass stays."""

    def __init__(self, spec, body, width):
        super().__init__(spec, body)
        self._half_width = 0.5 * width
        self._path = np.asarray(spec.path, float)[:, :-1]
        self._length = float(np.linalg.norm(np.diff(self._path, axis=0), axis=1).sum())
        self._cut_to = -np.inf

    def state(self):
        return {**super().state(), "cut_to": self._cut_to}

    def restore(self, state):
        super().restore(state)
        self._cut_to = state["cut_to"]

    def _reached(self, time):
        if self._spec.speed is None:
            return self._length
        return min(self._length, (time - self._spec.start) * self._spec.speed)

    def apply(self, simulation):
        if simulation.time < self._spec.start:
            return
        reached = self._reached(simulation.time)
        # Half a cell at a time: the grid sees no finer, and each time costs a copy of the particles.
        if reached < self._length and reached < self._cut_to + 0.5 * simulation.scene.solver.dx:
            return
        self._cut_to = reached
        self.done = reached >= self._length
        solver = simulation.solver
        fields = simulation.particles
        own = np.flatnonzero(fields["body"] == self._body)
        plan = fields["position"][own, :-1]
        hit = own[self._distance(plan, reached) <= self._half_width]
        if len(hit) == 0:
            return
        table, layout = solver.particles.table(), solver.particles.layout
        law = solver.materials.laws[fields["material"][hit[0]]]
        state = law.severed_state()
        if state is None:
            raise InputError.at("events.body", self._spec.body, f"{law.kind} has no severed state, so it cannot be cut")
        table[hit[:, None], layout.columns("state").start + np.arange(len(state))] = state
        table[hit, layout.columns("elastic")] = 0.0
        table[hit, layout.columns("stress")] = 0.0
        solver.rewrite(table)

    def _distance(self, plan, reached):
        """Distance in plan [m] from the part of the path that the saw has passed."""
        best, passed = np.full(len(plan), np.inf), 0.0
        for a, b in zip(self._path, self._path[1:], strict=False):
            length = np.linalg.norm(b - a)
            end = min(1.0, max(0.0, (reached - passed) / length)) if length > 0.0 else 0.0
            t = np.clip(((plan - a) @ (b - a)) / max(length**2, 1e-300), 0.0, end)
            best = np.minimum(best, np.linalg.norm(plan - a - t[:, None] * (b - a), axis=1))
            passed += length
            if passed >= reached:
                break
        return best


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
                raise InputError.at("events.centre", list(spec.centre), f"no snow of {spec.body} within {spec.radius} m")
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
