"""Whether the class of ground friction of a run holds where its flow came to rest."""

from snowmpm.scenes.friction import ByVolume
from snowmpm.scenes.friction_cards import friction_cards


def class_chosen(model):
    """Name of the friction card that the volume of the release of a `Model` has chosen; None where the scene names its
    friction."""
    terrain = model.scene.terrain
    if terrain is None or not isinstance(terrain.friction, ByVolume):
        return None
    return model.friction.law.card


def doubts_after(model, numbers):
    """Texts, one a reason, why the friction card of a `Model` may not hold: by the volume of the release and the
    altitude of the run-out (`runout_z` of the hazard numbers), where the heights of the terrain are altitudes."""
    terrain = model.scene.terrain
    if terrain is None or isinstance(terrain.friction, int | float) or terrain.kind != "dem":
        return []
    name = model.friction.law.card
    card = friction_cards().get(name)
    if card is None or "runout_z" not in numbers:
        return []
    found = card.doubts(volume=model.release_volume, runout_altitude=numbers["runout_z"])
    return [f"{name}: {doubt}" for doubt in found]
