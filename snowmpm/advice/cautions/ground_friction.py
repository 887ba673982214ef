"""Rule: a published class of ground friction outside the range it was calibrated for."""

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
