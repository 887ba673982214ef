"""A drag in proportion to mass and velocity, dv/dt = a - c v, solved exactly over a step of constant a:

    v(t + dt) = k v + s a,    k = exp(-c dt),    s = (1 - k) / c

Its work over a step, c dt times twice the kinetic energy T, is booked as tanh(c dt) (T_before + T_after): exact for
motion that nothing drives, and second order in dt otherwise.
"""

import math


class Damping:
    """coefficient c [1/s] from `start` to `stop` [s], and until all is at rest when `rest_speed` [m/s] is given."""

    def __init__(self, spec):
        self._spec = spec
        self._moved, self._ended = False, False

    def coefficient(self, time, dt, speed):
        """Mean c [1/s] over a step of dt [s] from `time` [s]; speed: of the fastest particle now [m/s]."""
        spec = self._spec
        if spec.rest_speed is not None and time >= spec.start and not self._ended:
            self._ended = self._moved and speed < spec.rest_speed
            self._moved = self._moved or speed > spec.rest_speed
        stop = math.inf if spec.stop is None else spec.stop
        shared = min(time + dt, stop) - max(time, spec.start)
        return 0.0 if self._ended or shared <= 0.0 else spec.coefficient * shared / dt

    @property
    def until(self):
        """When it ends [s]; 0 without such a time."""
        return self._spec.stop or 0.0

    def state(self):
        """Progress, by name."""
        return {"moved": self._moved, "ended": self._ended}

    def restore(self, state):
        """Take over what `state()` gave."""
        self._moved, self._ended = state["moved"], state["ended"]


def decay(c, dt):
    """k [-] and s [s] of the docstring above."""
    return (math.exp(-c * dt), -math.expm1(-c * dt) / c) if c > 0.0 else (1.0, dt)
