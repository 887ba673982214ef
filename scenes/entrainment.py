"""Snow cover of a scene that a flow takes up.

    [terrain.entrainment]
    law = "rate"                            # "rate", "erosion_energy" or "strength"
    growth_rate = 0.001                     # 1/m
    thickness = { file = "cover.tif" }      # m, normal to the ground
    density = 150.0                         # kg/m3
"""

from typing import Annotated

from pydantic import AfterValidator

from snowmpm.ground.entrainment import EntrainmentLaw
from snowmpm.scenes.friction import rasters_exist

Entrainment = Annotated[EntrainmentLaw, AfterValidator(rasters_exist)]
