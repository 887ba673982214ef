"""Rule: a powder layer is an experiment, always."""

from snowmpm.advice.cautions.caution import Caution, rule
from snowmpm.components.powder_layer.declare import EXPERIMENT


@rule("depth")
def an_experiment(facts):
    """Said of each scene that has one."""
    table = facts.scene.get("powder_layer")
    if table:
        says = f"{EXPERIMENT}; suspension is chosen, and two sources of air entrainment differ by 3"
        yield Caution("", "powder_layer.profile", says,
                      "take no hazard zone from it; run both air_entrainment, and half and twice suspension_rate")
