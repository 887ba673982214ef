"""Constitutive library: laws as data, their stress update as a Taichi function, and a material point to drive them."""

from typing import Annotated

if __name__ != "snowmpm.materials":
    raise ImportError("import this package as snowmpm.materials")

from snowmpm.registry import LAWS

from .anticrack_cam_clay import AnticrackCamClay
from .cohesive_cam_clay import CohesiveCamClay
from .cohesive_crack import CohesiveCrack
from .critical_state_hypoplastic import CriticalStateHypoplastic
from .drucker_prager import DruckerPrager
from .elastic import Elastic
from .experiments import EXPERIMENTS, measure, measure_path
from .hyperelastic import NeoHookean, StVenantKirchhoff
from .hypoplastic import Hypoplastic
from .law import Law, StateVariable
from .loading_file import LoadingFile, read_loading
from .loading_stage import LoadingError, LoadingStage
from .material_point import MaterialPoint, Path
from .measurement import Measurement
from .mixed_control import MixedControl
from .modified_cam_clay import ModifiedCamClay
from .mohr_coulomb import MohrCoulomb
from .mu_i import MuI
from .mu_phi_i import MuPhiI
from .softening_cone import SofteningCone
from .solid_to_gas import SolidToGas
from .stomakhin_snow import StomakhinSnow
from .stress_update import StressUpdate, Updated
from .symmetric import pack, unpack
from .von_mises import VonMises
from .wet_snow import WetSnow

for law in (Elastic, NeoHookean, StVenantKirchhoff, CohesiveCrack, VonMises, DruckerPrager, SofteningCone, MohrCoulomb,
            MuI, MuPhiI, ModifiedCamClay, CohesiveCamClay, AnticrackCamClay, StomakhinSnow, Hypoplastic,
            CriticalStateHypoplastic, SolidToGas, WetSnow):
    LAWS.add(law)

Material = Annotated[Law, LAWS.member()]

__all__ = [
    "EXPERIMENTS",
    "LAWS",
    "AnticrackCamClay",
    "CohesiveCamClay",
    "CohesiveCrack",
    "CriticalStateHypoplastic",
    "DruckerPrager",
    "Elastic",
    "Hypoplastic",
    "Law",
    "LoadingError",
    "LoadingFile",
    "LoadingStage",
    "Material",
    "MaterialPoint",
    "Measurement",
    "MixedControl",
    "ModifiedCamClay",
    "MohrCoulomb",
    "MuI",
    "MuPhiI",
    "NeoHookean",
    "Path",
    "SofteningCone",
    "SolidToGas",
    "StVenantKirchhoff",
    "StateVariable",
    "StomakhinSnow",
    "StressUpdate",
    "Updated",
    "VonMises",
    "WetSnow",
    "measure",
    "measure_path",
    "pack",
    "read_loading",
    "unpack",
]
