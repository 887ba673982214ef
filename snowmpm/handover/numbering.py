"""Numbers of particles that are made while a scene runs."""

import numpy as np


class Numbering:
    """bodies (n,): index of the body of each number so far; origins (n, dim) [m]: where its snow was at time zero."""

    def __init__(self, bodies, origins):
        self.bodies, self.origins = np.asarray(bodies), np.asarray(origins, float)

    def give(self, handed):
        """Numbers (n,), never used before, for `handover.handed.Handed`."""
        first, n = len(self.bodies), len(handed.population.volumes)
        bodies = np.searchsorted(handed.body_starts, np.arange(n), side="right") - 1
        self.bodies = np.concatenate([self.bodies, bodies])
        self.origins = np.concatenate([self.origins, handed.start])
        return first + np.arange(n)

    def state(self):
        """All of them, by name."""
        return {"bodies": self.bodies, "origins": self.origins}

    @classmethod
    def of(cls, state):
        """From a `state()`."""
        return cls(state["bodies"], state["origins"])
