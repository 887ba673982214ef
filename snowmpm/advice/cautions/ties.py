"""Rules: surfaces tied to a prescribed motion by a penalty."""

from snowmpm.advice.cautions.caution import Caution, rule
from snowmpm.setup.loaded_faces import penalty_of

GAP = 0.02
"""Share of a body's extent from which on the layer that a tie stands for is worth a word."""


@rule("mpm")
def soft_tie(facts):
    """Ties that give way as much as a layer of dx / penalty of the body's own material would."""
    names = [body.name for body in facts.scene.bodies]
    for i, force in enumerate(facts.scene.forces):
        if force.kind == "displacement":
            cells = facts.extent(names.index(force.body))
            penalty = penalty_of(facts.scene, force)
            share = 1.0 / (penalty * cells)
            if share > GAP:
                yield Caution("", f"forces.{i}.penalty", f"{penalty:g} lets the surface give way as a layer of"
                              f" {100.0 * share:.2g} % of {force.body} would",
                              f"penalty = {1.0 / (GAP * cells):.2g} or more")
