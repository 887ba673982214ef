"""Snow cover of a scene that a flow takes up: its table, and what it does not go with.

    [terrain.entrainment]
    law = "rate"                            # "rate", "erosion_energy" or "strength"
    growth_rate = 0.001                     # 1/m
    thickness = { file = "cover.tif" }      # m, normal to the ground
    density = 150.0                         # kg/m3
"""

from typing import Annotated

from pydantic import AfterValidator

from snowmpm.components.contract import Component
from snowmpm.components.entrainment.laws import EntrainmentLaw, Rate
from snowmpm.errors import InputError
from snowmpm.registry import COMPONENTS
from snowmpm.scenes.friction import rasters_exist
from snowmpm.scenes.spec import Spec


class OfTerrain(Spec):
    """Keys of the ground."""

    entrainment: Annotated[EntrainmentLaw, AfterValidator(rasters_exist)] | None = None
    """snow cover that a flow takes up; method = "depth" only"""


def asked(scene):
    """(key, value) of the table."""
    if scene.terrain and scene.terrain.entrainment:
        yield "terrain.entrainment.law", scene.terrain.entrainment.law


def refuse(scene):
    """Raise InputError for a law by friction beside water that has none."""
    law = scene.terrain.entrainment
    if scene.water and scene.water.scheme == "two_phase" and not isinstance(law, Rate):
        raise InputError.at("terrain.entrainment.law", law.law, 'must be "rate" beside two phases: water has no'
                            " friction that breaks the cover up", scene.source)


COMPONENTS.add(Component("entrainment", __package__, "snow cover taken up", asked, order=40,
                         keys={"terrain": OfTerrain}, refuse=refuse))
