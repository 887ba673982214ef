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
from snowmpm.scenes.gravity import Gravity
from snowmpm.scenes.spec import Spec


class OfTerrain(Spec):
    """Keys of the ground."""

    entrainment: Annotated[EntrainmentLaw, AfterValidator(rasters_exist)] | None = None
    """snow cover that a flow takes up at the bed; method = "depth" or "mpm" only"""


def asked(scene):
    """(key, value) of the table."""
    if scene.terrain and scene.terrain.entrainment:
        yield "terrain.entrainment.law", scene.terrain.entrainment.law


def told(scene):
    """That particles of the cover come later than the start that `check` weighs."""
    if scene.solver.method == "depth":
        return {}
    return {"snow cover": "joins as particles; mass, particles, memory and time: of what flows at the start"}


def borne_by(scene):
    """Whether the law asks for the friction of the ground."""
    return not isinstance(scene.terrain.entrainment, Rate)


def refuse(scene):
    """Raise InputError for a law by friction where there is none, and for what particles in space do not go with."""
    law = scene.terrain.entrainment
    if borne_by(scene) and scene.water and scene.water.scheme == "two_phase":
        raise InputError.at("terrain.entrainment.law", law.law, 'must be "rate" beside two phases: water has no'
                            " friction that breaks the cover up", scene.source)
    if scene.solver.method != "depth":
        _refuse_in_space(scene, law)


def _refuse_in_space(scene, law):
    if borne_by(scene) and scene.terrain.contact == "stick":
        raise InputError.at("terrain.entrainment.law", law.law, 'must be "rate" beside terrain.contact = "stick", which'
                            " has no friction that breaks the cover up", scene.source)
    there = {"gravity that changes": isinstance(scene.gravity, Gravity), "water": scene.water,
             "initial.from": scene.initial.from_run is not None,
             "laid_ahead of a body": any(body.get("laid_ahead") for body in scene.bodies),
             "periodic sides of the domain": scene.domain and "periodic" in scene.domain.sides(
                 scene.dimension).values()}
    if found := [name for name, is_there in there.items() if is_there]:
        raise InputError.at("terrain.entrainment.law", law.law, f"does not go with {' and '.join(found)} by"
                            f' "{scene.solver.method}"', scene.source)


COMPONENTS.add(Component("entrainment", __package__, "snow cover taken up", asked, order=40,
                         keys={"terrain": OfTerrain}, beside=("switch", "zone", "saw_test"), refuse=refuse, told=told,
                         cautions=f"{__package__}.cautions"))
