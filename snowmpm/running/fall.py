"""The largest speed that a fall over all of the ground can give."""

import math

import numpy as np

from snowmpm import components
from snowmpm.scenes.gravity import Gravity

TERRAINS = ("dem", "mesh", "profile")

DEEPER = 2.0
"""Depths of the snow added to the fall: the front of a dam break on dry ground, 2 sqrt(g h), has the speed of a fall
by 2 h."""

EXCESS = 1.05
"""What the scheme may add to columns."""
THROWN = 3.0
"""The same for snow in space, where snow throws other snow: in the library's flow_cold_dense the fastest is at 1.68 of
a fall, 61 m/s, and all energies balance."""


def fall_speed(model):
    """sqrt(v^2 + 2 g H) [m/s], v the largest speed of the snow at the start and H the fall from its highest place to
    the lowest of the ground, with DEEPER and EXCESS or THROWN; inf where more than the weight drives it, or it may fall
    for ever.

    Energy: snow that nothing but its weight drives cannot be faster, but for snow that other snow throws.
    """
    scene = model.scene
    driven = scene.forces or scene.events or isinstance(scene.gravity, Gravity) or any(
        item.motion for item in scene.obstacles) or any(component.moves_on for component in components.used(scene))
    if driven or scene.terrain is None or scene.terrain.kind not in TERRAINS or scene.saw_test:
        return math.inf
    if scene.domain and "periodic" in scene.domain.sides(scene.dimension).values():
        return math.inf
    gravity, snow = scene.gravity_vector, model.population
    if any(gravity[:-1]):
        return math.inf
    lowest = model.surface.lower[-1] if scene.solver.in_plan else model.lower[-1]
    speed2 = 0.0 if snow.velocities is None else (np.asarray(snow.velocities, float) ** 2).sum(axis=1).max(initial=0.0)
    depth = float(snow.volumes.max()) / scene.solver.spacing(3) ** 2 if scene.solver.in_plan else model.depth
    fall = max(snow.positions[:, -1].max() - lowest, 0.0) + DEEPER * depth
    excess = EXCESS if scene.solver.in_plan else THROWN
    return excess * math.sqrt(speed2 + 2.0 * abs(gravity[-1]) * fall) if np.isfinite(fall) else math.inf
