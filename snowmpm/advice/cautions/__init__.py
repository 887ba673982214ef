"""Failures of the atlas that may affect a scene: one rule per failure, by its measured border."""

import importlib

from snowmpm import components
from snowmpm.advice.cautions import (  # noqa: F401
    bending,
    contacts,
    cracks,
    deep_release,
    ground_friction,
    layers,
    mass,
    never,
    round_off,
    saw_column,
    shallow,
    small_bodies,
    sph_sums,
    standing,
    time_steps,
    transfers,
    weak_layers,
    zone,
)
from snowmpm.advice.cautions.caution import RULES, Caution

__all__ = ["Caution", "cautions"]


for component in components.declared():
    if component.cautions:
        importlib.import_module(component.cautions)


def cautions(facts):
    """`Caution`s of a scene (`SceneFacts`), in the order of the rules."""
    method = facts.scene.solver.method
    if not RULES.get(method):
        return [Caution("", "solver.method", f"where {method} fails was not measured", "compare it with another")]
    return [caution for rule in RULES[method] for caution in rule(facts)]
