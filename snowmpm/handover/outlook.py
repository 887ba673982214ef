"""What the methods of a scene will have to do, before it runs: the hand-overs rehearsed at time zero.

The moment of a hand-over that follows from the snow is estimated: snow that slides down the slope under it from when
the last event has begun reaches a speed v after v / a, a = g (sin - mu cos); it reaches a region at half the largest
speed that sliding blocks have (`depth.blocks`).
"""

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from snowmpm.handover.conversion import converted
from snowmpm.handover.filling import coefficient
from snowmpm.handover.moment import Moment, distance
from snowmpm.particles.fields import ParticleFields
from snowmpm.scenes.switch import FLOWING, REACHED, parts
from snowmpm.scenes.zone import within
from snowmpm.seeding.regions import regions_of
from snowmpm.stepping.abilities import course as course_of

LEAST_PULL = 0.05
"""Acceleration over g that a slope is taken to give at least."""
MARGIN = 8
"""Cells of the particles around the snow in which a zone is rehearsed."""
BREAKS_WITHIN = 1.0
"""Time [s] after the last event within which a weak layer is taken to break."""


@dataclass
class Leg:
    """A part of the run by one method: its scene, model and solver at its start, begin and end [s] (None: that of the
    run)."""

    scene: Any
    model: Any
    solver: Any
    begin: float = 0.0
    end: float | None = None


def legs(model, solver):
    """`Leg`s of the scene of a model with its solver; one for a scene without switches."""
    scene, start = model.scene, model.population.positions
    scenes, found = parts(scene), [Leg(model.scene, model, solver)]
    for i, switch in enumerate(scene.switch):
        before, part = found[-1], scenes[i + 1]
        before.end = min(scene.end_time, max(before.begin, _expected(switch, before, f"switch.{i}")))
        fields = ParticleFields(before.solver.particles, before.model.body_starts)
        handed = converted(fields, start, before.scene, part, model)
        after, start = replace(model, scene=part, population=handed.population,
                               body_starts=handed.body_starts), handed.start
        found.append(Leg(part, after, after.solver(), before.end))
    return [*found, _of_zone(found[0])] if scene.zone else found


def _of_zone(leg):
    """`Leg` of the zone of a scene: with all of its snow at once, from when the first reaches the region."""
    scene, model = leg.scene, leg.model
    part = within(scene)
    handed = converted(ParticleFields(leg.solver.particles), model.population.positions, scene, part, model)
    room = MARGIN * part.solver.dx
    lower, upper = model.lower.copy(), model.upper.copy()
    lower[:2] = np.maximum(lower[:2], handed.population.positions[:, :2].min(axis=0) - room)
    upper[:2] = np.minimum(upper[:2], handed.population.positions[:, :2].max(axis=0) + room)
    after = replace(model, scene=part, population=handed.population, body_starts=handed.body_starts, lower=lower,
                    upper=upper, obstacles=[])
    way = distance(regions_of(scene.zone.region, model.surface, scene.base_dir, "zone.region"),
                   model.population.positions)
    return Leg(part, after, after.solver(), min(scene.end_time, _arrival(leg, way)))


def _expected(switch, leg, key):
    """Time [s] at which a hand-over is expected."""
    scene = leg.scene
    moment = Moment(switch, leg.model.surface, scene.base_dir, key)
    if switch.time is not None:
        return switch.time
    begun = max([leg.begin, *(event.start for event in scene.events)])
    if switch.when == FLOWING:
        return begun + switch.speed / _pull(leg)
    if switch.when == REACHED:
        return begun + _arrival(leg, moment.distance(leg.model.population.positions))
    return begun + BREAKS_WITHIN


def _arrival(leg, way):
    """Time [s] after which the snow has gone a way [m]."""
    course = course_of(leg.solver, leg.scene.end_time, leg.scene.output.interval)
    speed = course.speed if course else math.sqrt(2.0 * _pull(leg) * way)
    return 2.0 * way / max(speed, 1e-3)


def _pull(leg):
    """Acceleration [m/s2] of a block on the mean slope under the snow."""
    steepness = np.nanmean(leg.model.surface.normal(leg.model.population.positions[:, :2])[:, 2])
    g = float(np.linalg.norm(leg.scene.gravity_vector))
    return g * max(LEAST_PULL, math.sqrt(1.0 - steepness**2) - coefficient(leg.scene.terrain) * steepness)
