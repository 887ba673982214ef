"""The end of a run whose snow has come to rest."""

from snowmpm.quantities.motion import FILMS, REST_MOMENTUM, REST_SHARE
from snowmpm.scenes.stop import ends_at_rest

RESTED = "came to rest"
"""Beginning of the text for an end at rest."""
HOLD = 0.05
"""Default share of end_time that rest must last."""


class StopAtRest:
    """Checks after each frame whether the snow of a simulation is at rest (`snowmpm.quantities.motion`), and for how
    long. It does not check while something is still to happen: a saw cut, a removal, a load that grows or will be
    removed, a change of gravity or of a force, a release."""

    def __init__(self, simulation):
        scene = simulation.scene
        self._simulation, self._wanted = simulation, ends_at_rest(scene)
        stop = scene.stop
        self._moving = REST_SHARE if stop.moving_share is None else stop.moving_share
        self._momentum = REST_MOMENTUM if stop.momentum_share is None else stop.momentum_share
        self._films = FILMS if stop.moving_share is None and stop.momentum_share is None else -1.0
        self._hold = stop.hold or HOLD * scene.end_time
        self.since = None
        """Time of the first frame of the current period of rest [s]; None while the snow moves."""

    def state(self):
        """All that a continuation needs, by name."""
        return {"since": self.since}

    def restore(self, state):
        """Restore the result of `state()`."""
        self.since = state["since"]

    def look(self):
        """After a frame."""
        motion, time = self._simulation.motion, self._simulation.time
        rests = motion.has_moved and motion.moving_share <= self._moving and motion.momentum_share <= self._momentum
        rests = rests or (motion.has_moved and motion.momentum_share <= self._films)
        solver = self._simulation.solver
        to_come = any(event.to_come(time) for event in self._simulation.events)
        to_come = to_come or any(one.to_come(time) for one in solver.adapters)
        to_come = to_come or any(body.start_time > time for body in self._simulation.scene.bodies)
        if not rests or to_come:
            self.since = None
        elif self.since is None:
            self.since = time

    @property
    def reached(self):
        """Whether the run is over."""
        return bool(self._wanted and self.since is not None
                    and self._simulation.time - self.since >= self._hold * (1.0 - 1e-9))

    @property
    def reason(self):
        """Why the run ended, in words: "came to rest at t = 31.5 s", or its end_time, and since when it has been at
        rest."""
        if self.reached:
            return f"{RESTED} at t = {self.since:.6g} s"
        since = "" if self.since is None else f", at rest since t = {self.since:.6g} s"
        return f"end_time = {self._simulation.scene.end_time:.6g} s{since}"


def rested(run):
    """Whether a `Run` ended because its snow had come to rest."""
    return run.summary.get("ended", "").startswith(RESTED)
