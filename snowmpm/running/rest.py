"""The end of a run whose snow has come to rest."""

from snowmpm.quantities.motion import REST_MOMENTUM, REST_SHARE
from snowmpm.scenes.stop import ends_at_rest

RESTED = "came to rest"
"""How the reason of such an end begins."""
HOLD = 0.05
"""Share of end_time that rest must last when the scene does not say."""


class StopAtRest:
    """Looks after each frame whether the snow of a simulation rests, as `snowmpm.quantities.motion` has it, and for how
    long. While something is to come it does not look: a saw, a removal, a load that grows or will be taken away,
    gravity or a force that changes."""

    def __init__(self, simulation):
        scene = simulation.scene
        self._simulation, self._wanted = simulation, ends_at_rest(scene)
        stop = scene.stop
        self._moving = REST_SHARE if stop.moving_share is None else stop.moving_share
        self._momentum = REST_MOMENTUM if stop.momentum_share is None else stop.momentum_share
        self._hold = stop.hold or HOLD * scene.end_time
        self.since = None
        """Time of the first of the frames at rest without a break, up to now [s]; None while it moves."""

    def state(self):
        """All that a continuation needs, by name."""
        return {"since": self.since}

    def restore(self, state):
        """Take over what `state()` gave."""
        self.since = state["since"]

    def look(self):
        """After a frame."""
        motion, time = self._simulation.motion, self._simulation.time
        rests = motion.has_moved and motion.moving_share <= self._moving and motion.momentum_share <= self._momentum
        forcing = self._simulation.solver.forcing
        to_come = any(event.to_come(time) for event in self._simulation.events) or (forcing and forcing.to_come(time))
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
        """Why the run ended, in words: "came to rest at t = 31.5 s", or its end_time and since when it rests, if so."""
        if self.reached:
            return f"{RESTED} at t = {self.since:.6g} s"
        since = "" if self.since is None else f", at rest since t = {self.since:.6g} s"
        return f"end_time = {self._simulation.scene.end_time:.6g} s{since}"


def rested(run):
    """Whether a `Run` ended because its snow had come to rest."""
    return run.summary.get("ended", "").startswith(RESTED)
