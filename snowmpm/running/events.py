"""Events that act on bodies during a simulation: saw cut, load, removal.

Each event has `apply(simulation)`, called before every step until it is `done`; its current `load` on the snow, or
None; and its progress as `state()` and `restore(state)`.
"""

import numpy as np

from snowmpm.errors import InputError
from snowmpm.registry import resolved
from snowmpm.running.event import Event
from snowmpm.saw_test.saw import Saw
from snowmpm.saw_test.weak_layer import weak_layer_of


class Cut(Event):
    """A saw cut through a body. In plan, particles of the body within half the cut width of the saw's path lose their
    strength and their stress (the law's `severed_state()`); their mass stays."""

    def __init__(self, spec, body, dx):
        super().__init__(spec, body)
        self._half_width = 0.5 * (spec.width or 2.0 * dx)
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
        # In pieces of half a cell: the grid resolves no less.
        if reached < length and reached < self._cut_to + 0.5 * simulation.scene.solver.dx:
            return
        law = simulation.law_of_body(self._body)
        if law.severed_state() is None:
            raise InputError.at("events.body", self._spec.body, f"{law.kind} has no severed state, so it cannot be cut")
        simulation.solver.sever(self._piece(max(self._cut_to, 0.0), reached), self._half_width,
                                simulation.numbers_of_body(self._body), law.severed_state())
        self._cut_to = reached
        self.done = reached >= length

    def _piece(self, start, end):
        """Corners of the path between two distances along it [m], (k, dim - 1)."""
        inside = self._at[(self._at > start) & (self._at < end)]
        along = np.r_[start, inside, end]
        return np.stack([np.interp(along, self._at, column) for column in self._path.T], axis=1)


class Push(Event):
    """A force that ramps up, and then stays or is removed."""

    def to_come(self, time):
        spec = self._spec
        stays = spec.stop is None and time >= spec.start + spec.ramp
        return not self.done and not stays


class Load(Push):
    """A force on the snow within `radius` of a point, such as a skier: the same acceleration for all of it, so that
    the total is the given force once it acts fully. It grows linearly over the scene's `ramp`."""

    def __init__(self, spec, body, dx):
        super().__init__(spec, body)
        self._full = None  # acceleration by the whole force [m/s2]

    def state(self):
        return {**super().state(), "load": self.load, "full": self._full}

    def restore(self, state):
        super().restore(state)
        self.load, self._full = state["load"], state["full"]

    def apply(self, simulation):
        spec = self._spec
        stop = np.inf if spec.stop is None else spec.stop
        if simulation.time >= stop:
            self.load, self.done = None, True
            simulation.follow_loads()
        elif simulation.time >= spec.start:
            if self._full is None:
                self._full = np.asarray(spec.force) / self._mass(simulation)
            share = grown(simulation.time - spec.start, spec.ramp)
            if self.load is None or share < 1.0 or not np.array_equal(self.load[2], self._full):
                self.load = spec.centre, spec.radius, share * self._full
                simulation.follow_loads()

    def _mass(self, simulation):
        spec, fields = self._spec, simulation.particles
        near = np.linalg.norm(fields["position"] - np.asarray(spec.centre), axis=1) < spec.radius
        if not (near & (fields["body"] == self._body)).any():
            nothing = f"no snow of {spec.body} within {spec.radius} m"
            raise InputError.at("events.centre", list(spec.centre), nothing)
        return float(fields["mass"][near].sum())


class BodyLoad(Push):
    """A force on a whole body, such as the weight of new snow: the same acceleration for all of it.

    It acts on particles, since nodes do not distinguish bodies: before each step, they get the momentum of the time
    since the last step.
    """

    def __init__(self, spec, body, dx):
        super().__init__(spec, body)
        self._given = 0.0  # impulse on the body so far over the full force [s]
        self._mass, self._of = 0.0, (-1, 0.0)
        """of the body [kg], and the number and mass of all particles when it was last summed: water comes and goes"""

    def state(self):
        return {**super().state(), "given": self._given, "mass": self._mass, "of": self._of}

    def restore(self, state):
        super().restore(state)
        self._given = state["given"]
        if "mass" in state:  # checkpoints of older versions have none
            self._mass, (count, mass) = float(state["mass"]), state["of"]
            self._of = int(count), float(mass)

    def apply(self, simulation):
        spec = self._spec
        stop = np.inf if spec.stop is None else spec.stop
        time = min(simulation.time, stop) - spec.start
        if time <= 0.0:
            return
        grows = min(time, spec.ramp)
        given = time - grows + (0.5 * grows**2 / spec.ramp if spec.ramp > 0.0 else 0.0)
        particles = simulation.solver.particles
        if self._of != (particles.count, particles.mass):
            self._of, fields = (particles.count, particles.mass), simulation.particles
            first, end = simulation.numbers_of_body(self._body)  # without snow that joined it on the way
            self._mass = float(fields["mass"][(fields["id"] >= first) & (fields["id"] < end)].sum())
        if self._mass > 0.0:
            gain = (given - self._given) / self._mass * np.asarray(spec.force)
            simulation.solver.push(simulation.numbers_of_body(self._body), gain, self._mass)
        self._given, self.done = given, simulation.time >= stop


def grown(time, ramp):
    """Share of the full force `time` [s] after its start."""
    return 1.0 if time >= ramp else time / ramp


class Remove(Event):
    """Removal of a whole body at once; its particles count as removed."""

    def apply(self, simulation):
        if simulation.time >= self._spec.start:
            simulation.solver.remove(simulation.particles["body"] == self._body)
            self.done = True


def load(spec, body, dx):
    """A force on a part of a body, or on all of it."""
    return (BodyLoad if spec.centre is None else Load)(spec, body, dx)


def make_events(scene):
    """The scene's events, ready to be applied; last the saw of a saw test."""
    names, dx = [body.name for body in scene.bodies], scene.solver.dx
    bodies = [spec.get("body") for spec in scene.events]
    events = [resolved(type(spec).ACTS)(spec, None if body is None else names.index(body), dx)
              for spec, body in zip(scene.events, bodies, strict=True)]
    test = scene.saw_test
    if test:
        events.append(Saw(weak_layer_of(scene), names.index("weak_layer"), test.notch, test.cut_length, test.saw_speed,
                          test.saw_start))
    return events
