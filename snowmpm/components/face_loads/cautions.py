"""Rules: surfaces tied to a prescribed motion by a penalty."""

from collections import Counter

from snowmpm.advice.cautions.caution import Caution, beyond, rule
from snowmpm.components.face_loads.from_scene import penalty_of

SETTINGS = "one end, 16 cells", "both ends, 16 cells"
"""Of the entry: where a body has one tie, and where it has more."""


@rule("mpm")
def soft_tie(facts):
    """Ties that give way as much as a layer of dx / penalty of the body's own material would."""
    names = [body.name for body in facts.scene.bodies]
    ties = Counter(force.body for force in facts.scene.forces if force.kind == "displacement")
    for i, force in enumerate(facts.scene.forces):
        if force.kind == "displacement":
            cells = facts.extent(names.index(force.body))
            penalty = penalty_of(facts.scene, force)
            if border := beyond("soft_tie", SETTINGS[ties[force.body] > 1], penalty * cells):
                yield Caution(border.entry, f"forces.{i}.penalty", f"{penalty:g} lets the surface give way as a layer"
                              f" of {100.0 / (penalty * cells):.2g} % of {force.body} would",
                              f"penalty = {border.value / cells:.2g} or more")
