"""Rules: a release far deeper than snow lies, and columns too wide for the front of a deep one."""

from snowmpm.advice.cautions.caution import Caution, rule
from snowmpm.methods import METHODS
from snowmpm.setup.release_plan import release_plan

NARROW = 0.05
"""solver.depth.rim that lets the front of a dam break come within 2 % on twenty cells of its depth."""
DEEPEST = 6.0
"""Mean depth of a release [m] from which on it is doubted; slabs are 0.2 to 5 m thick."""


@rule(*METHODS)
def deep_release(facts):
    """The mean depth of snow on an elevation model."""
    terrain = facts.scene.terrain
    if terrain is None or terrain.kind != "dem" or facts.scene.dimension != 3:
        return
    area = release_plan(facts.model).area
    depth = facts.model.release_volume / area if area > 0.0 else 0.0
    if depth > DEEPEST:
        yield Caution("", "bodies", f"the release is {depth:.3g} m deep in the mean",
                      "thickness and top are in metres; slabs are 0.2 to 5 m thick")


@rule("depth")
def parted_front(facts):
    """Columns that stand apart where snow deeper than a cell is let go at its rim (cases D2, D4 and P8)."""
    solver = facts.scene.solver
    if solver.depth.scheme != "columns":
        return
    for i, body in enumerate(facts.scene.bodies):
        top = body.shape.top if body.shape.kind == "layer" else None
        if isinstance(top, int | float) and top - body.shape.bottom > solver.dx and not solver.depth.rim:
            yield Caution("", "solver.depth.rim", f"bodies.{i} ({body.name}) is deeper than a cell of {solver.dx:g} m:"
                          " the front of a break parts into lone columns, which come up to 50 % too short or too far",
                          f"solver.depth.rim = {NARROW:g}")
