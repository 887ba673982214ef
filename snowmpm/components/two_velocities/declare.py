"""Water with particles and a velocity of its own beside the grains: the table `[water]` with scheme = "v_w", and what
it does not go with.

    [water]
    scheme = "v_w"
    permeability = 1.0e-8
    bulk_modulus = 1e7          # Pa
"""

from typing import ClassVar, Literal

from pydantic import model_validator

from snowmpm.components.contract import Component
from snowmpm.errors import InputError
from snowmpm.registry import COMPONENTS, WATER
from snowmpm.scenes.spec import NonNegative, Positive, refuse
from snowmpm.scenes.water import OwnWater
from snowmpm.schemes import TRANSFERS
from snowmpm.water.refusals import DOUBLE, refuse_of_pores


@WATER.add
class MovingWater(OwnWater):
    """Water with particles and a velocity of its own beside the grains: it runs through the pores, leaves the snow and
    pools; method = "mpm" only."""

    EXAMPLES: ClassVar = {"dry": ["rock"]}

    scheme: Literal["v_w"]
    """v_w: grains and water have a velocity each, v and w, with drag between them; explicit"""
    bulk_modulus: Positive = 2.2e9
    """K_w of water [Pa]. The step follows its waves: 100 times the largest pressure is enough for flow, and keeps
    compression below 1 %"""
    pressure: NonNegative = 0.0
    """pressure at the start [Pa], without table"""

    @model_validator(mode="after")
    def _goes_together(self):
        if self.table is not None and self.pressure != 0.0:
            raise refuse("does not go with table, which gives the pressure", "pressure", self.pressure)
        return self


def asked(scene):
    """(key, value) of the table."""
    if scene.water is not None and scene.water.scheme == "v_w":
        yield "water.scheme", "v_w"


def refuse_beside(scene):
    """Raise InputError for what does not go with water that has a velocity of its own."""
    refuse_of_pores(scene)
    solver, terrain = scene.solver, scene.terrain
    if not TRANSFERS[solver.transfer].flip:
        raise InputError.at("solver.transfer", solver.transfer, 'must be "aflip" or "flip" beside water.scheme = "v_w",'
                            " which needs the velocity before the forces", scene.source)
    if scene.initial.stress not in ("none", "settle"):
        raise InputError.at("initial.stress", scene.initial.stress, 'must be "none" or "settle" beside'
                            ' water.scheme = "v_w"', scene.source)
    for i, event in enumerate(scene.events):
        if event.kind == "melt":
            raise InputError.at(f"events.{i}.kind", event.kind, 'does not go with water.scheme = "v_w": take "rain"'
                                f" with rate = {event.rate:.3g}", scene.source)
        if event.kind in ("drainage", "load"):
            raise InputError.at(f"events.{i}.kind", event.kind, 'does not go with water.scheme = "v_w": take "u_p"',
                                scene.source)
    # Laws take their stress from all particles of a column; the grains' own is known where they touch a surface only
    rubbing = [("terrain", terrain)] if terrain else []
    rubbing += [(f"obstacles.{i}", obstacle) for i, obstacle in enumerate(scene.obstacles)]
    for key, surface in rubbing:
        if surface.contact not in ("stick", "symmetric") and not isinstance(surface.friction, int | float):
            raise InputError.at(f"{key}.friction", "a law", 'must be a number beside water.scheme = "v_w"',
                                scene.source)


COMPONENTS.add(Component(
    "two_velocities", __package__, "water with a velocity of its own", asked, order=2,
    owns=("the velocity fields of nodes", "the spare number of a node"),
    beside=("zone", "solver.kernel"), double=DOUBLE, refuse=refuse_beside,
    events=("rain",), fills=f"{__package__}.mpm:with_water", laws="snowmpm.water.phases_from_scene:laws",
    cautions=f"{__package__}.cautions", atlas=f"{__package__}.atlas"))
