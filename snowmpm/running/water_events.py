"""Events that act on the water in the snow: rain, melt, and borders that begin or cease to let water out."""

import numpy as np

from snowmpm.running.event import Event
from snowmpm.water.adapter import WaterAdapter


def water_of(solver):
    """The `WaterAdapter` of a solver."""
    return next(one for one in solver.adapters if isinstance(one, WaterAdapter))


class Wetting(Event):
    """Rain on, or melt of, the highest snow of each column under the sky, in the steps that begin while it lasts."""

    def apply(self, simulation):
        spec, water, time = self._spec, water_of(simulation.solver), simulation.time
        stop = np.inf if spec.stop is None else spec.stop
        if time >= stop:
            water.rain.pop(self, None)
            self.done = True
        elif time >= spec.start:
            water.rain[self] = spec.rate, self._inside

    def _inside(self, plan):
        """Which of the places plan (k, dim - 1) [m] it wets."""
        inside, region = np.ones(len(plan), bool), self._spec.region
        for bounds, along in zip(() if region is None else (region.x, region.y), plan.T, strict=False):
            if bounds is not None:
                inside &= (along >= bounds[0]) & (along < bounds[1])
        return inside


class Drainage(Event):
    """A border lets water out from now on, or no more."""

    def apply(self, simulation):
        if simulation.time >= self._spec.start:
            water_of(simulation.solver).outlets.drained[self._spec.border] = self._spec.becomes == "drained"
            self.done = True
