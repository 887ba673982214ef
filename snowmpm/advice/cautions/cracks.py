"""Rules: cracks with an energy of their own, and what spreads them over more than a row of cells."""

from snowmpm.advice.cautions.caution import Caution, rule

KIND = "cohesive_crack"


@rule("mpm")
def spread_crack(facts):
    """Material that cracks, in cells whose particles do not deform as one."""
    if facts.scene.solver.f_bar != "whole" and any(law.kind == KIND for law in facts.model.laws):
        yield Caution("", "solver.f_bar", "cracks spread into the cells beside them, and take 1.05 to 1.5 times"
                      " fracture_energy", 'solver.f_bar = "whole"')


@rule("sph")
def crack_among_neighbours(facts):
    """Material that cracks, by SPH, whose sums reach over several particles."""
    if any(law.kind == KIND for law in facts.model.laws):
        yield Caution("", "solver.method", "what a crack takes by SPH was not measured: its sums spread it over several"
                      " rows of particles", 'solver.method = "mpm" with f_bar = "whole"')
