"""Rules: cracks with an energy of their own."""

import numpy as np

from snowmpm.advice.cautions.caution import Caution, rule

KIND = "cohesive_crack"


@rule("mpm", "sph")
def yields_before_it_cracks(facts):
    """Cracks in a law that yields in tension before their strength is reached."""
    for name, law in facts.scene.materials.items():
        if law.kind != KIND or law.bulk is None:
            continue
        pulled = np.diag([law.strength, 0.0, 0.0])
        if law.bulk.yield_function(pulled, np.array(law.bulk.initial_state())) > 0.0:
            yield Caution("", f"materials.{name}.bulk", f"{law.bulk.kind} yields when it is drawn along one axis, below"
                          " the strength of its cracks: none begins so", "a smaller strength, or more cohesion in bulk")


@rule("mpm")
def crack_that_begins_anew(facts):
    """Cracks that make way for new ones, in rows of cells that a crack keeps open."""
    for name, law in facts.scene.materials.items():
        if law.kind == KIND and law.reset:
            yield Caution("", f"materials.{name}.reset", "a row of cells that is drawn on cracks again and again, and"
                          " takes fracture_energy each time",
                          f"materials.{name}.cracks = 2 with materials.{name}.reset = false")
