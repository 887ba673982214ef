"""What a hand-over gives to the method that takes over."""

from dataclasses import dataclass

import numpy as np

from snowmpm.particles.population import Population


@dataclass
class Handed:
    """population: in the order of bodies; body_starts: number of the first particle of each body; start (n, dim) [m]:
    where the snow of each particle was at time zero, a mean over its mass."""

    population: Population
    body_starts: np.ndarray
    start: np.ndarray

    def state(self):
        """What a solver needs to be built again, whose particles are then restored (`snowmpm.io.checkpoint`)."""
        columns = {name: vars(self.population)[name] for name in ("positions", "volumes", "material")}
        return {"population": columns, "body_starts": self.body_starts, "start": self.start}

    @classmethod
    def of(cls, state):
        """From a `state()`."""
        return cls(Population(**state["population"]), state["body_starts"], state["start"])


def first_numbers(body, n_bodies):
    """Number of the first particle of each body, of bodies in ascending order (n,)."""
    return np.searchsorted(body, np.arange(n_bodies))
