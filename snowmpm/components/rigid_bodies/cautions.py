"""Rule: bodies on each other."""

from snowmpm.advice.cautions.caution import beyond, rule, worded
from snowmpm.components.rigid_bodies.from_scene import is_free

HEAVIER = 30.0
"""Ratio of the masses of two bodies from which on `heavy_on_light` is asked."""


@rule("mpm", "sph")
def heavy_on_light(facts):
    """Free bodies so unlike in mass that contact between them does not settle."""
    bodies = [(i, obstacle) for i, obstacle in enumerate(facts.model.obstacles) if is_free(obstacle)]
    if len(bodies) < 2:
        return
    masses = [obstacle.motion.mass_properties.mass for _, obstacle in bodies]
    ratio = max(masses) / min(masses)
    setting = "2 blocks" if len(bodies) == 2 else "6 blocks"
    if ratio > HEAVIER and (border := beyond("heavy_on_light", setting, ratio)):
        yield worded(border, f"obstacles.{bodies[masses.index(max(masses))][0]}.free", ratio)
