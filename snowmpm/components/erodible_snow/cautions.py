"""Rule: covers too thin for cells."""

from snowmpm.advice.cautions.caution import Caution, rule

FEW = 2.0
"""Cells through a cover."""


@rule("mpm")
def thin_cover(facts):
    """A cover thinner than what can shear in itself."""
    for i, body in enumerate(facts.scene.bodies):
        shape = body.shape
        if body.laid_ahead is not None and shape.kind == "layer" and isinstance(shape.top, int | float):
            cells = (shape.top - shape.bottom) / facts.dx
            if cells < FEW * (1.0 - 1e-9):
                says = f"a cover of {cells:.2g} cells shares its velocity with the flow on it: it is taken up at once"
                cure = f"solver.dx = {facts.dx * cells / FEW:.3g}; or terrain.entrainment (snowmpm docs snow_cover)"
                yield Caution("", f"bodies.{i}.shape.top", says, cure)
