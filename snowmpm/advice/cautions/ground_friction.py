"""Rules: a published class of ground friction outside the range it was calibrated for; snow that gives way before the
ground does."""

import math

import numpy as np

from snowmpm.advice.cautions.caution import Caution, rule
from snowmpm.methods import METHODS
from snowmpm.scenes.friction_cards import friction_cards


@rule(*METHODS)
def class_of_friction(facts):
    """A friction card whose class does not fit the volume of the release or the altitude of the ground."""
    terrain = facts.scene.terrain
    if terrain is None or isinstance(terrain.friction, int | float) or facts.scene.dimension != 3:
        return
    model = facts.model
    card = friction_cards().get(model.friction.law.card)
    if card is None:
        return
    heights = model.surface.vertices[:, -1]
    # Heights of a raster are altitudes; those of a plane or a mesh begin anywhere
    ground = (float(np.min(heights)), float(np.max(heights))) if terrain.kind == "dem" else None
    for doubt in card.doubts(volume=model.release_volume, ground=ground):
        yield Caution("", "terrain.friction.card", f"{model.friction.law.card}: {doubt}",
                      "name the class that fits, or calibrate (`snowmpm list` names the classes)")


@rule("mpm", "sph")
def snow_weaker_than_the_ground(facts):
    """Snow without cohesion on the ground that yields inside before the friction of the ground is reached.

    At critical state, sheared in a plane, snow bears tau = M / sqrt(3) p. On ground with more friction than that it
    shears over its own lowest layer, and is slowed by its own friction.
    """
    terrain = facts.scene.terrain
    if terrain is None or terrain.contact == "stick":
        return
    mu = terrain.friction if isinstance(terrain.friction, int | float) else terrain.friction.get("mu")
    if not isinstance(mu, int | float):
        return
    for body in facts.scene.bodies:
        snow = facts.scene.materials[body.material]
        M = snow.get("critical_slope")
        slides = M is None or snow.get("cohesion", 0.0) > 0.0 or mu <= M / math.sqrt(3.0)
        if slides or body.shape.kind != "layer" or body.shape.bottom > 0.0:
            continue
        yield Caution("", f"materials.{body.material}.critical_slope",
                      f"{M:.3g}: snow that has yielded bears {M / math.sqrt(3.0):.2g} times its pressure in shear, the"
                      f" ground {mu:.2g}: it shears above the ground, faster than the friction of the ground alone"
                      " would let it",
                      f"from {math.ceil(100.0 * math.sqrt(3.0) * mu) / 100.0:.2f} on it slides on the ground")
        return
