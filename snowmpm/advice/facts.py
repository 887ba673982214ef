"""Properties of a scene in the terms of the atlas: cells, contrasts, distances, speeds."""

import itertools
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from snowmpm import components
from snowmpm.advice.breaking import breaking_between
from snowmpm.advice.budget import Budget
from snowmpm.advice.calibration import measured_speed
from snowmpm.particles.blocks import keys_of
from snowmpm.running.forecast import forecast
from snowmpm.scenes.stop import rests_until
from snowmpm.schemes import BASES
from snowmpm.stepping.abilities import expected_dt

FARTHEST = 3
"""Largest distance of neighbouring bodies [cells]."""
MOST_PAIRED = 300
"""Largest number of bodies whose pairs are examined: the number of pairs grows with its square."""


@dataclass(frozen=True)
class Pair:
    """Two bodies near each other on one velocity field, or on two (separate); distance: cells between them, 0 where
    they touch."""

    first: int
    second: int
    distance: int
    separate: bool


class SceneFacts:
    """Properties of a scene to compare with the borders of the atlas."""

    def __init__(self, scene, model, solver, begin=0.0, until=None):
        """begin, until [s]: time at which the method takes over, and hands over, of a scene with several."""
        self.scene, self.model, self.solver = scene, model, solver
        self.begin, self._until = begin or rests_until(scene), until
        self.dx, self.dim = scene.solver.dx, scene.dimension

    @property
    def per_axis(self):
        """Particles along each axis of a full cell at the start."""
        return self.scene.solver.filling ** (1.0 / self.dim)

    @property
    def kernel(self):
        """Basis whose settings of the atlas count: for averaged hats, which it has in a few entries only, the quadratic
        spline."""
        chosen = self.scene.solver.kernel
        return "quadratic" if BASES[chosen].box else chosen

    @property
    def spline(self):
        """Name of a setting of the atlas: "quadratic" or "cubic", with "shape" for that gradient."""
        return self.kernel + (" shape" if self.scene.solver.gradient == "shape" else "")

    def law(self, body):
        """Law of a body as scaled to this grid."""
        return self.model.laws[list(self.scene.materials).index(self.scene.bodies[body].material)]

    def positions(self, body):
        return self.model.population.positions[self._starts[body]:self._starts[body + 1]]

    @cached_property
    def _starts(self):
        """First particle of each body, and the number of particles."""
        return [*self.model.body_starts, len(self.model.population.volumes)]

    def thickness(self, body):
        """Thickness [cells] of a body: of a layer normal to the ground, else its least extent."""
        shape = self.scene.bodies[body].shape
        if shape.kind == "layer" and isinstance(shape.top, int | float):
            return (shape.top - shape.bottom) / self.dx
        x = self.positions(body)
        if shape.kind == "layer":
            return float(self.model.depth / self.dx)
        return float((np.ptp(x, axis=0) / self.dx + 1.0 / self.per_axis).min())

    def extent(self, body):
        """Longest extent of a body [cells]."""
        return float((np.ptp(self.positions(body), axis=0) / self.dx).max())

    @cached_property
    def pairs(self):
        """Pairs of bodies less than FARTHEST cells apart; none for a scene of more than MOST_PAIRED bodies."""
        if len(self.scene.bodies) > MOST_PAIRED:
            return []
        cells = [np.unique(np.floor(self.positions(i) / self.dx).astype(np.int64), axis=0)
                 for i in range(len(self.scene.bodies))]
        keys = [np.unique(keys_of(found)) for found in cells]
        separate = components.velocity_fields(self.scene) > 0
        return [Pair(i, j, distance, bool(separate[i] or separate[j])) for i, j in _close(cells)
                if (distance := _apart(cells[i], keys[j])) is not None]

    @property
    def start_speed(self):
        """Largest speed [m/s] of the snow at the start, and of obstacles at any time."""
        moving = [body.velocity for body in self.scene.bodies]
        moving += [obstacle.motion.velocity for obstacle in self.scene.obstacles if obstacle.motion]
        moving += [obstacle.motion.first_velocity for obstacle in self.model.obstacles]
        return max((float(np.linalg.norm(velocity)) for velocity in moving), default=0.0)

    @property
    def gravity(self):
        """Magnitude of gravity, the largest if it changes [m/s2]."""
        course = self.model.gravity
        return float(np.linalg.norm(self.scene.gravity_vector if course is None else course.strongest))

    @property
    def fall_speed(self):
        """Speed of a fall through the whole height of the scene [m/s]."""
        height = float(self.model.upper[-1] - self.model.lower[-1])
        if self.model.surface is not None:
            x = self.model.population.positions
            height = float(x[:, -1].max() - self.model.surface.lower[-1])
        g = self.gravity
        return np.sqrt(2.0 * g * min(height, 0.5 * g * self.scene.end_time**2))

    @property
    def wave_speed(self):
        return self.solver.particles.materials.wave_speed

    @property
    def least_strain(self):
        """Elastic strain [-] of the stiffest material under the weight of the snow or the fastest motion."""
        stiffest = max(self.model.laws, key=lambda law: law.bulk_modulus)
        modulus = stiffest.density * stiffest.wave_speed() ** 2
        g = self.gravity
        return max(stiffest.density * g * self.model.depth / modulus, self.start_speed / self.wave_speed)

    @cached_property
    def budget(self):
        """Cost of a run on one thread of this machine."""
        return Budget(self, speed=measured_speed())

    def with_scene(self, scene):
        """Approximate facts of a scene that differs only in settings or materials: the particles stay the same."""
        return SceneFacts(scene, replace(self.model, scene=scene), self.solver, self.begin, self._until)

    @cached_property
    def forecast(self):
        """`Forecast` of the run."""
        return forecast(self.scene, self.solver)

    @cached_property
    def steps(self):
        """Number of steps of the whole run, or of the method's part of it."""
        return max(1.0, self.steps_until(self.end) - self.steps_until(self.begin))

    @property
    def end(self):
        """Time at which the run ends, or the method hands over [s]."""
        return self.forecast.end if self._until is None else min(self._until, self.forecast.end)

    def steps_until(self, time):
        """Number of steps until a time [s]: of a method that knows its course its share of them, else with the length
        of the first steps, shorter while bonds break."""
        if self.forecast.course:
            return self.forecast.steps * min(1.0, time / self.forecast.end)
        most = self.scene.output.interval  # no step goes beyond a frame
        long = self.scene.solver.dt or min(most, expected_dt(self.solver)[0])
        short = self.scene.solver.dt or min(most, expected_dt(self.solver, breaking=True)[0])
        if short == long:
            return time / long
        begin, end = self._breaking
        return time / long + max(0.0, min(end, time) - begin) * (1.0 / short - 1.0 / long)

    @cached_property
    def _breaking(self):
        return breaking_between(self.scene)


def _close(cells):
    """Pairs i < j of sets of cells whose boxes lie at most FARTHEST cells apart."""
    lower, upper = (np.array([end(found, axis=0) for found in cells]) for end in (np.min, np.max))
    near = (lower[:, None] <= upper[None] + FARTHEST).all(axis=-1)
    return np.argwhere(np.triu(near & near.T, 1)).tolist()


def _apart(cells, keys):
    """Empty cells between one set of cells (n, dim) and another given by its sorted keys, None from FARTHEST on."""
    dim = cells.shape[1]
    for distance in range(FARTHEST):
        reach = range(-distance - 1, distance + 2)
        for step in itertools.product(reach, repeat=dim):
            if max(map(abs, step)) == distance + 1 and np.isin(keys_of(cells + np.array(step)), keys).any():
                return distance
    return None
