"""Constitutive library: laws as data, their stress update as a Taichi function, and a material point to drive them."""

from typing import Annotated

if __name__ != "snowmpm.materials":
    raise ImportError("import this package as snowmpm.materials")

from pydantic import Field

from .anticrack_cam_clay import AnticrackCamClay
from .cohesive_cam_clay import CohesiveCamClay
from .elastic import Elastic
from .experiments import EXPERIMENTS, measure, measure_path
from .law import Law, StateVariable
from .leg import Leg, LoadingError
from .loading_file import LoadingFile, read_loading
from .material_point import MaterialPoint, Path
from .measurement import Measurement
from .mixed_control import MixedControl
from .modified_cam_clay import ModifiedCamClay
from .stomakhin_snow import StomakhinSnow
from .stress_update import StressUpdate, Updated
from .symmetric import pack, unpack

Material = Annotated[
    Elastic | ModifiedCamClay | CohesiveCamClay | AnticrackCamClay | StomakhinSnow,
    Field(discriminator="kind"),
]

LAWS = {
    law.model_fields["kind"].default: law
    for law in (Elastic, ModifiedCamClay, CohesiveCamClay, AnticrackCamClay, StomakhinSnow)
}

__all__ = [
    "EXPERIMENTS",
    "LAWS",
    "AnticrackCamClay",
    "CohesiveCamClay",
    "Elastic",
    "Law",
    "Leg",
    "LoadingError",
    "LoadingFile",
    "Material",
    "MaterialPoint",
    "Measurement",
    "MixedControl",
    "ModifiedCamClay",
    "Path",
    "StateVariable",
    "StomakhinSnow",
    "StressUpdate",
    "Updated",
    "measure",
    "measure_path",
    "pack",
    "read_loading",
    "unpack",
]
