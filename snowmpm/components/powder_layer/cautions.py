"""Rules: a powder layer is an experiment, always; loads on obstacles are those of the flow alone."""

from snowmpm.advice.cautions.caution import Caution, rule
from snowmpm.components.powder_layer.declare import EXPERIMENT


@rule("depth")
def an_experiment(facts):
    """Said of each scene that has one."""
    table = facts.scene.get("powder_layer")
    if table:
        turns = [*(["both laws of air_entrainment"] if table.air_entrainment != "none" else []),
                 *(["half and twice suspension_rate"] if table.suspension != "none" else [])]
        cure = f"; run {', and '.join(turns)}" if turns else ""
        yield Caution("", "powder_layer", EXPERIMENT, f"take no hazard zone from it{cure}")


@rule("depth")
def loads_without_the_cloud(facts):
    """Where obstacles are loaded."""
    if facts.scene.get("powder_layer") and facts.scene.get("obstacles"):
        yield Caution("", "obstacles", "their loads are those of the flow alone: the cloud passes through them, and"
                      " takes mass from the flow", "add the pressure of the map cloud_peak_pressure_experiment by hand")
