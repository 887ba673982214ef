"""Intrinsic permeability K [m2] of a porous skeleton: a number, a raster, or a function of porosity and grain size.

    [water]                              [water.permeability]
    permeability = 1e-9                  law = "calonne"      # or "kozeny_carman"
                                         grain_size = 1e-3    # diameter of the grains [m]

The water moves by q = -(K k_r / mu) (grad p - rho_w g), q [m/s]: the hydraulic conductivity is K rho_w g / mu [m/s].
"""

from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BaseModel, Discriminator, Field, Tag

from snowmpm.annotations import Floats
from snowmpm.keys import TABLE_CONFIG, Keyed

ICE_DENSITY = 917.0
"""[kg/m3]"""

NUMBER, TABLE = "<number>", "<table>"
"""Marks of the forms in the location of an error; no key of a scene can be equal to them."""

Number = Annotated[float, Field(strict=True, gt=0.0, le=1.0, allow_inf_nan=False)]
"""Permeability [m2]: above 0."""


class _Table(Keyed, BaseModel):
    model_config = TABLE_CONFIG


class RasterPermeability(_Table):
    """A raster in plan."""

    law: Literal["raster"] = "raster"
    file: Annotated[str, Field(strict=True, min_length=1, examples=["permeability.tif"])]
    """.asc or .tif raster of the permeability [m2], relative to the scene file; 3-D only"""


class OfGrains(_Table):
    """A function of porosity and grain size."""

    grain_size: Annotated[float, Field(strict=True, gt=0.0, le=0.1, allow_inf_nan=False)]
    """diameter of the grains d [m]; of snow 3 / (SSA rho_ice) times 2, the optical diameter"""

    def of(self, porosity: Floats) -> Floats:
        """Permeability [m2] at a porosity n, 0 < n < 1."""
        raise NotImplementedError


class KozenyCarman(OfGrains):
    """K = d² n³ / (180 (1 - n)²), spheres of diameter d.

    Carman (1937), reprinted 1997, doi:10.1016/S0263-8762(97)80003-2.
    """

    law: Literal["kozeny_carman"]

    def of(self, porosity: Floats) -> Floats:
        """Permeability [m2]."""
        n = np.asarray(porosity, float)
        return self.grain_size**2 * n**3 / (180.0 * (1.0 - n) ** 2)


class Calonne(OfGrains):
    """K = 3.0 r² exp(-0.0130 rho), r = d / 2 the equivalent sphere radius, rho = 917 (1 - n) kg/m3 the snow's density.

    Calonne et al. (2012), doi:10.5194/tc-6-939-2012: 35 samples of 103 to 544 kg/m3.
    """

    law: Literal["calonne"]

    def of(self, porosity: Floats) -> Floats:
        """Permeability [m2]."""
        density = ICE_DENSITY * (1.0 - np.asarray(porosity, float))
        return 0.75 * self.grain_size**2 * np.exp(-0.0130 * density)


LAWS = ("calonne", "kozeny_carman", "raster")
"""Names of the tables."""


def law_of(value: Any) -> str:
    """Name of the law of a permeability, also as it is written; NUMBER for a number."""
    if isinstance(value, dict):
        return str(value.get("law", "raster"))
    return value.law if isinstance(value, _Table) else NUMBER


Permeability = Annotated[
    Annotated[Number, Tag(NUMBER)] | Annotated[RasterPermeability, Tag("raster")]
    | Annotated[KozenyCarman, Tag("kozeny_carman")] | Annotated[Calonne, Tag("calonne")], Discriminator(law_of)]
"""Number [m2], raster, or law."""

IRREDUCIBLE = 0.07
"""Saturation that capillary forces hold in snow (Colbeck 1974, doi:10.3189/S002214300002339X)."""


def relative_permeability(saturation: Floats) -> Floats:
    """Share k_r of the permeability at a saturation S, S_i = 0.07: ((S - S_i) / (1 - S_i))³.

    Colbeck (1972), doi:10.3189/S0022143000022346: water that percolates through snow by its weight alone.
    """
    effective = (np.asarray(saturation, float) - IRREDUCIBLE) / (1.0 - IRREDUCIBLE)
    return np.clip(effective, 0.0, 1.0) ** 3
