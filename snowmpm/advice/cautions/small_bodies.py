"""Rules: bodies that the cells do not resolve."""

from snowmpm.advice.cautions.caution import Caution, accepted, rounded_down, rule
from snowmpm.advice.cautions.layers import too_shallow
from snowmpm.components import carried
from snowmpm.methods import METHODS

LEAST_CELLS = 2.0
"""Thickness [cells] from which on strain across a body can vary in it: a spline reaches over two cells."""

FITTED = 0.95
"""Share of the extent of a body that its lattice of particles spans at least."""

ON_GRID = [name for name, entry in METHODS.items() if entry.capabilities.grid and not entry.capabilities.plan]


@rule(*ON_GRID)
def thin_body(facts):
    """A body of any shape thinner than LEAST_CELLS that touches no other; layers that may slide have a rule of their
    own (`layers.shallow_flow`)."""
    touching = {body for pair in facts.pairs if pair.distance == 0 for body in (pair.first, pair.second)}
    if facts.begin > 0.0:
        return
    shallow = too_shallow(facts) is not None
    for i, body in enumerate(facts.scene.bodies):
        if i in touching or carried(facts.scene, body) or (shallow and body.shape.kind == "layer"):
            continue
        cells = facts.thickness(i)
        if cells < FITTED * LEAST_CELLS:
            dx = rounded_down(cells * facts.dx / LEAST_CELLS)
            whole = facts.extent(i) + 1.0 / facts.per_axis < 1.0 + 1e-6
            within = "it is smaller than a cell" if whole else "strain across it is one number"
            cure = f"solver.dx = {dx:g} or less" if accepted(facts, {"solver.dx": dx}) else "a finer grid"
            yield Caution("", f"bodies.{i} ({body.name})", f"{cells:.2g} cells thick: {within}", cure)
