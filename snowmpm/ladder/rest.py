"""Rungs for what is at rest or fails: slope stability, settlement, release."""

import numpy as np

from snowmpm.ladder.questions import RELEASE, STRENGTH
from snowmpm.ladder.rung import CELLS, Rung, in_cells, nearest_cells, spacing
from snowmpm.ladder.saw_tests import INTERFACE
from snowmpm.strength.record import slices_of

SLICES, REDUCED, IMPLICIT, EXPLICIT = "slices", "reduction", "implicit", "mpm"
TIMES = (4.0, 2.0, 1.0, 0.5)
"""Spacings of the grid over that of the scene."""
STRENGTH_CELLS = (5, 10, 20, 40)
"""Cells over the height of a slope."""
BLIND = {
    SLICES: "strain and stress: circles through soil of one kind (Bishop)",
    REDUCED: "what is smaller than a cell; a surface of failure is a cell wide",
    IMPLICIT: "swings and waves: balances of forces, one after the other",
    INTERFACE: "stress and waves within the weak layer, what is smaller than a cell",
    EXPLICIT: "what is smaller than a cell",
}


def strength_rungs(facts, ask):
    """`Rung`s for the factor of safety of a slope."""
    scene = facts.scene

    def slices():
        found = slices_of(scene, facts.gravity)
        return {"factor-of-safety": found[0].factor} if found else {}

    yield Rung(SLICES, BLIND[SLICES], answers=slices)
    for cells in STRENGTH_CELLS:
        yield Rung(in_cells(REDUCED, cells), BLIND[REDUCED], {"solver.dx": spacing(facts.model.depth, cells)},
                   trials=True)


def rest_rungs(facts, ask):
    """`Rung`s for settlement: solved balances, and damped explicit steps, on several grids."""
    scene, depth = facts.scene, facts.model.depth
    damped = {} if scene.get("damping") else {"damping": {"coefficient": critical_damping(facts)}}
    for method, solver, more in (
            (IMPLICIT, {"precision": "f64", "implicit": {"time": "quasi_static"}}, {"damping": None}),
            (EXPLICIT, {}, damped)):
        for cells in CELLS[2:]:
            dx = spacing(depth, cells)
            own = {"solver.dx": dx} if scene.solver.method == method else {
                "solver": {"method": method, "dx": dx, **solver}}
            yield Rung(in_cells(method, cells), BLIND[method], {**own, **more})


def critical_damping(facts):
    """Coefficient [1/s] that lets the slowest swing of the snow over its depth H go over into creep,
    2 omega with omega = pi c / (2 H), c the speed of its waves."""
    slowest = min(law.wave_speed() for law in facts.model.laws)
    return float(f"{np.pi * slowest / facts.model.depth:.3g}")


def release_rungs(facts, ask):
    """`Rung`s for whether a slab releases: the scene on grids by their spacing over its own, for which a weak layer was
    tuned as a rule."""
    kind = _kind(facts.scene)
    for times in TIMES:
        yield Rung(_times(kind, times), BLIND[kind], {"solver.dx": float(f"{times * facts.dx:.4g}")})


def _times(kind, times):
    return f"{kind}, {times:g} x its dx"


def _kind(scene):
    """Whether the weak layer of a scene is an interface."""
    return INTERFACE if any(body.get("interface") for body in scene.bodies) else scene.solver.method


def own_name(facts, group):
    """Name of the rung that a scene stands on, or is nearest to. group: of the question."""
    if group == STRENGTH:
        return in_cells(REDUCED, nearest_cells(facts.model.depth, facts.dx, STRENGTH_CELLS))
    if group == RELEASE:
        return _times(_kind(facts.scene), 1.0)
    method = facts.scene.solver.method
    swings = "undamped " if method == EXPLICIT and not facts.scene.get("damping") else ""
    return swings + in_cells(method, nearest_cells(facts.model.depth, facts.dx))
