"""Snow cover that a flow in space fractures, ploughs and takes up: its key, and what it does not go with.

    [[bodies]]
    name = "cover"
    material = "old_snow"
    shape = { kind = "layer", bottom = 0.0, top = 0.6 }
    laid_ahead = 6.0                       # m
"""

from snowmpm.components.contract import Component
from snowmpm.errors import InputError
from snowmpm.registry import COMPONENTS
from snowmpm.scenes.gravity import Gravity
from snowmpm.scenes.spec import Positive, Spec

LEAST = 4.0
"""Cells of `laid_ahead`: a flow that comes within a cell of the rim, which is held, would wait there for ever."""
COLUMN = "undisturbed"
"""Of particles: 1 of snow cover that lies as it was laid."""


class OfBody(Spec):
    """Keys of a body."""

    laid_ahead: Positive | None = None
    """snow cover: its particles are laid, at rest, as soon as snow that flows is this near in plan [m], and belong to
    the flow once they have moved; method = "mpm" only"""


def asked(scene):
    """(key, value) of each."""
    for i, body in enumerate(scene.bodies):
        if body.laid_ahead is not None:
            yield f"bodies.{i}.laid_ahead", body.laid_ahead


def told(scene):
    """That the cover comes later than the start that `check` weighs."""
    ahead = [f"{body.name} {body.laid_ahead:g} m" for body in scene.bodies if body.laid_ahead is not None]
    return {"laid ahead": f"{', '.join(ahead)}; mass: of what is laid at the start, particles and time: of all"}


def refuse(scene):
    """Raise InputError for a cover that is all there is, that moves, whose start has to be found, or that others act
    on before it is there."""
    if isinstance(scene.gravity, Gravity):
        key, value = next(asked(scene))
        raise InputError.at(key, value, "does not go with gravity that changes, which moves snow beside the flow",
                            scene.source)
    covers = {body.name for body in scene.bodies if body.laid_ahead is not None}
    for i, event in enumerate(scene.events):
        if event.get("body") in covers:
            raise InputError.at(f"events.{i}.body", event.body, "must be a body without laid_ahead, which is there from"
                                " the start", scene.source)
    for key, value in asked(scene):
        body = scene.bodies[int(key.split(".")[1])]
        if value < (least := LEAST * scene.solver.dx) * (1.0 - 1e-9):
            raise InputError.at(key, value, f"must be at least {LEAST:g} cells, {least:g} m", scene.source)
        if any(body.velocity):
            raise InputError.at(key, value, "does not go with velocity: a cover lies at rest", scene.source)
        if all(other.laid_ahead is not None for other in scene.bodies):
            raise InputError.at(key, value, "needs a body without it, the snow that flows", scene.source)
        if scene.initial.stress == "settle":
            raise InputError.at(key, value, 'does not go with initial.stress = "settle": take "geostatic"',
                                scene.source)


COMPONENTS.add(Component(
    "erodible_snow", __package__, "snow cover laid ahead", asked, order=45, keys={"bodies": OfBody},
    beside=("switch", "zone", "saw_test", "initial.from", "periodic sides of the domain", 'water.scheme = "v_w"',
            'water.scheme = "u_p"'),
    refuse=refuse, lies=lambda scene, body: body.laid_ahead is not None, told=told,
    fills=f"{__package__}.mpm:marked", cautions=f"{__package__}.cautions"))
