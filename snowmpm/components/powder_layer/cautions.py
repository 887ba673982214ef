"""Rules: a powder layer is an experiment; loads on obstacles are those of the flow alone; keys that do nothing."""

from snowmpm.advice.cautions.caution import Caution, rule
from snowmpm.components.powder_layer.declare import EXPERIMENT, PowderLayer


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


@rule("depth")
def keys_without_effect(facts):
    """Where another key decides."""
    table = facts.scene.get("powder_layer")
    if not table:
        return
    given, usual = table.model_dump(), PowderLayer().model_dump()
    idle = [("grain_diameter", "fall_speed decides", table.fall_speed is not None),
            ("suspension_rate", 'suspension = "none"', table.suspension == "none"),
            ("suspension_stress", f'suspension = "{table.suspension}"', table.suspension != "shear_excess"),
            ("cover_rate", "cover_load = 0", table.cover_load == 0.0),
            ("cover_stress", "cover_load = 0", table.cover_load == 0.0)]
    for key, why, holds in idle:
        if holds and given[key] != usual[key]:
            yield Caution("", f"powder_layer.{key}", f"has no effect: {why}", "leave one of the two out")
