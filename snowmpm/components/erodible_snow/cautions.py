"""Rules: covers too thin for cells, and laid too late."""

from snowmpm.advice.cautions.caution import Caution, rule

FEW, NEAR = 2.0, 4.0
"""Cells through a cover, and to the flow when it is laid."""


@rule("mpm")
def thin_cover(facts):
    """A cover thinner than what can shear in itself."""
    for i, body in enumerate(facts.scene.bodies):
        shape = body.shape
        if body.laid_ahead is not None and shape.kind == "layer" and isinstance(shape.top, int | float):
            cells = (shape.top - shape.bottom) / facts.dx
            if cells < FEW * (1.0 - 1e-9):
                says = f"a cover of {cells:.2g} cells shares its velocity with the flow on it: it is taken up at once"
                yield Caution("", f"bodies.{i}.shape.top", says, f"solver.dx = {facts.dx * cells / FEW:.3g}")


@rule("mpm")
def late_cover(facts):
    """A cover that is laid when the flow is about to touch it."""
    for i, body in enumerate(facts.scene.bodies):
        if body.laid_ahead is not None and body.laid_ahead < NEAR * facts.dx * (1.0 - 1e-9):
            says = f"the cover is laid {body.laid_ahead / facts.dx:.2g} cells ahead: the flow may be there before"
            yield Caution("", f"bodies.{i}.laid_ahead", says, f"laid_ahead = {NEAR * facts.dx:g} or more")
