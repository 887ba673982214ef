"""Constitutive library: laws as data, their stress update as a Taichi function, and a material point to drive them."""

from typing import Annotated

if __name__ != "snowmpm.materials":
    raise ImportError("import this package as snowmpm.materials")

from pydantic import Field

from .anticrack_cam_clay import AnticrackCamClay
from .cohesive_cam_clay import CohesiveCamClay
from .elastic import Elastic
from .law import Law, StateVariable
from .material_point import MaterialPoint, Path
from .modified_cam_clay import ModifiedCamClay
from .stress_update import StressUpdate, Updated
from .symmetric import pack, unpack

Material = Annotated[
    Elastic | ModifiedCamClay | CohesiveCamClay | AnticrackCamClay,
    Field(discriminator="kind"),
]

LAWS = {
    law.model_fields["kind"].default: law for law in (Elastic, ModifiedCamClay, CohesiveCamClay, AnticrackCamClay)
}

__all__ = [
    "LAWS",
    "AnticrackCamClay",
    "CohesiveCamClay",
    "Elastic",
    "Law",
    "Material",
    "MaterialPoint",
    "ModifiedCamClay",
    "Path",
    "StateVariable",
    "StressUpdate",
    "Updated",
    "pack",
    "unpack",
]
