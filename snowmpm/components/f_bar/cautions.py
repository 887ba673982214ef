"""Rules: cracks in cells whose particles do not deform as one."""

from snowmpm.advice.cautions.caution import Caution, accepted, rule

CRACKS = "cohesive_crack"
NARROW = 4.0
"""Cells of the radius of a press (tests/components/f_bar/test_shared_deformation.py)."""


@rule("mpm")
def spread_crack(facts):
    """Material that cracks, in cells whose particles do not deform as one."""
    if facts.scene.solver.f_bar != "whole" and any(law.kind == CRACKS for law in facts.model.laws):
        yield Caution("", "solver.f_bar", "cracks spread into the cells beside them, and take 1.05 to 1.5 times"
                      " fracture_energy", 'solver.f_bar = "whole"' if accepted(facts, {"solver.f_bar": "whole"}) else
                      "cells small against the crack's way")

@rule("mpm")
def narrow_load(facts):
    """A press narrower than cells whose particles deform as one."""
    if facts.scene.solver.f_bar != "whole":
        return
    for i, obstacle in enumerate(facts.scene.obstacles):
        shape = obstacle.shape
        if shape.kind in ("sphere", "cylinder") and shape.radius < NARROW * facts.dx:
            says = (f"a round press of a radius of {shape.radius / facts.dx:.2g} cells moves nodes that means of cells"
                    " do not see: a quarter of its work was lost at 1.75 cells, 9 % at 3.5")
            yield Caution("", f"obstacles.{i}.shape.radius", says, "grips in its place, or a radius of four cells")


@rule("sph")
def crack_among_neighbours(facts):
    """Material that cracks, by SPH, whose sums reach over several particles."""
    if any(law.kind == CRACKS for law in facts.model.laws):
        yield Caution("", "solver.method", "a crack by SPH takes two rows of particles; only such along rows, opened"
                      " slowly, were measured, since disorder_damping brakes what opens", 'solver.method = "mpm" with'
                      ' f_bar = "whole"')
