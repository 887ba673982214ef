"""The laws that may lie around a crack."""

from typing import Annotated

from pydantic import Field

from .anticrack_cam_clay import AnticrackCamClay
from .cohesive_cam_clay import CohesiveCamClay
from .drucker_prager import DruckerPrager
from .elastic import Elastic
from .modified_cam_clay import ModifiedCamClay
from .mohr_coulomb import MohrCoulomb
from .mu_i import MuI
from .mu_phi_i import MuPhiI
from .softening_cone import SofteningCone
from .von_mises import VonMises
from .wet_snow import WetSnow

Bulk = Annotated[
    Elastic
    | VonMises
    | DruckerPrager
    | SofteningCone
    | MohrCoulomb
    | MuI
    | MuPhiI
    | ModifiedCamClay
    | CohesiveCamClay
    | AnticrackCamClay
    | WetSnow,
    Field(discriminator="kind"),
]
"""Laws of the stiffness of Hencky's elasticity, whose update of a strain needs no path: what a crack unloads is then
known. Others store a stress, or change their stiffness."""
