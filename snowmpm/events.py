"""What happens to bodies while a simulation runs: saw cut, load, removal.

Each event has `apply(simulation)`, called before every step, and is `done` when nothing is left to do.
"""

import numpy as np

from snowmpm.errors import InputError


class Cut:
    """A saw drawn through a body. Seen from above, particles of the body within half the width of the path that the
    saw has passed lose their strength and their stress: the law's `severed_state()`; their mass stays."""

    def __init__(self, spec, body, width):
        self.done = False
        self._spec, self._body = spec, body
        self._half_width = 0.5 * width
        self._path = np.asarray(spec.path, float)[:, :-1]
        self._length = float(np.linalg.norm(np.diff(self._path, axis=0), axis=1).sum())
        self._cut_to = -np.inf

    def _reached(self, time):
        if self._spec.speed is None:
            return self._length
        return min(self._length, (time - self._spec.start) * self._spec.speed)

    def apply(self, simulation):
        if simulation.time < self._spec.start:
            return
        reached = self._reached(simulation.time)
        # A quarter of a cell at a time: finer than the grid sees, and a copy of the particles each time.
        if reached < self._length and reached < self._cut_to + 0.25 * simulation.scene.solver.dx:
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


class Load:
    """A force on the snow within `radius` of a point, such as a skier: the same acceleration for all of it, so that
    the total is the force asked for when it sets in."""

    def __init__(self, spec, body):
        self.done = False
        self._spec, self._body = spec, body
        self._on = False

    def apply(self, simulation):
        spec = self._spec
        stop = np.inf if spec.stop is None else spec.stop
        if not self._on and spec.start <= simulation.time < stop:
            self._on = True
            fields = simulation.particles
            near = np.linalg.norm(fields["position"] - np.asarray(spec.centre), axis=1) < spec.radius
            mass = float(fields["mass"][near].sum())
            if not (near & (fields["body"] == self._body)).any():
                raise InputError.at("events.centre", list(spec.centre), f"no snow of {spec.body} within {spec.radius} m")
            simulation.loads.append((spec.centre, spec.radius, np.asarray(spec.force) / mass))
            self._mine = simulation.loads[-1]
            simulation.solver.set_loads(simulation.loads)
        elif self._on and simulation.time >= stop:
            simulation.loads = [load for load in simulation.loads if load is not self._mine]
            simulation.solver.set_loads(simulation.loads)
            self.done = True


class Remove:
    """A body taken away at once; its particles count as removed."""

    def __init__(self, spec, body):
        self.done = False
        self._spec, self._body = spec, body

    def apply(self, simulation):
        if simulation.time >= self._spec.start:
            simulation.solver.remove(simulation.particles["body"] == self._body)
            self.done = True


def make_event(spec, body, dx):
    """Event of a scene's events table; body: index of the body that it names."""
    if spec.kind == "cut":
        return Cut(spec, body, spec.width or 2.0 * dx)
    return {"load": Load, "remove": Remove}[spec.kind](spec, body)
