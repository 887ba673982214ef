"""Water with particles of its own that seeps through grains at rest: the table `[water]` with scheme = "seepage", and
what it does not go with.

    [water]
    scheme = "seepage"
    permeability = 1.0e-6       # m2
    bulk_modulus = 1e6          # Pa
"""

from typing import ClassVar, Literal

import numpy as np

from snowmpm.components.contract import Component
from snowmpm.errors import InputError
from snowmpm.registry import COMPONENTS, WATER
from snowmpm.scenes.spec import Positive
from snowmpm.scenes.water import OwnWater
from snowmpm.water.refusals import DOUBLE, refuse_of_pores


@WATER.add
class SeepageWater(OwnWater):
    """Water with particles of its own that seeps through grains at rest, leaves them and pools; method = "sph" only."""

    EXAMPLES: ClassVar = {"dry": ["rock"]}

    scheme: Literal["seepage"]
    """seepage: grains stay where they are; the pressure of the water is solved for in each step"""
    bulk_modulus: Positive = 1e6
    """K_w of water [Pa], which sets no step: 100 times the largest pressure keeps compression below 1 %, and 1000 times
    makes the pressure of single particles noisy"""


def asked(scene):
    """(key, value) of the table."""
    if scene.water is not None and scene.water.scheme == "seepage":
        yield "water.scheme", "seepage"


def refuse_beside(scene):
    """Raise InputError for what does not go with water that seeps through grains at rest."""
    refuse_of_pores(scene)
    beside = 'does not go with water.scheme = "seepage", whose grains are at rest'
    if scene.initial.stress != "none":
        raise InputError.at("initial.stress", scene.initial.stress, beside, scene.source)
    for i, event in enumerate(scene.events):
        if event.kind != "rain":
            raise InputError.at(f"events.{i}.kind", event.kind, f"{beside}: only rain does", scene.source)
    for i, body in enumerate(scene.bodies):
        if np.any(body.velocity):
            raise InputError.at(f"bodies.{i}.velocity", list(body.velocity), beside, scene.source)
    for name, side in (scene.domain.sides(scene.dimension) if scene.domain else {}).items():
        if side not in ("open", "slip", "symmetric"):
            raise InputError.at(f"domain.boundary.{name}", side, 'must be "slip", "symmetric" or "open" beside'
                                ' water.scheme = "seepage"', scene.source)
    found = {"terrain.kind": scene.terrain and scene.terrain.kind,
             "obstacles.0.name": scene.obstacles and scene.obstacles[0].name}
    for key, value in found.items():
        if value:
            raise InputError.at(key, value, 'does not go with water.scheme = "seepage": sides of the domain hold it,'
                                " and weight moves it", scene.source)


COMPONENTS.add(Component(
    "seepage", __package__, "water that seeps", asked, order=3, alone=True, beside=("zone",),
    double=DOUBLE, refuse=refuse_beside,
    events=("rain",), fills="snowmpm.water.phases_from_scene:with_water", laws="snowmpm.water.phases_from_scene:laws",
    builders={"sph": f"{__package__}.solver:SeepageSolver.of"},
    cautions=f"{__package__}.cautions", atlas=f"{__package__}.atlas"))
