"""Friction of the ground in a scene: a number, a law with its numbers, or a choice of laws by release volume.

    friction = 0.3          [terrain.friction]         [terrain.friction]
                            law = "voellmy"            card = "samos_at_medium"    # numbers given here override
                            mu = { file = "mu.tif" }   tau0 = 50.0                 # those of the card
                            xi = 2000.0
"""

from typing import Annotated, Any, ClassVar, Literal

from pydantic import AfterValidator, Field

from snowmpm.ground import FrictionLaw
from snowmpm.registry import GROUND_LAWS
from snowmpm.scenes.space import NUMBER, TABLE, by_type, check_file, require_dimension
from snowmpm.scenes.spec import NonNegative, Spec

BY_VOLUME = "by_volume"
"""Name in place of a law, of a friction that is one of several classes."""


class ByVolume(Spec):
    """A law chosen among the classes of a card by the volume of the release (3-D)."""

    EXAMPLES: ClassVar = {"card": "samos_at_auto"}

    law: Literal["by_volume"] = "by_volume"
    card: Annotated[str, Field(strict=True)]
    """friction card that lists the classes"""


def rasters_exist(law: Any) -> Any:
    """The law, whose rasters need a 3-D scene, and lie where the scene says."""
    for name, raster in law.rasters.items():
        require_dimension(3, f"a raster of {name}")
        check_file(raster.file, f"{name}.file")
    return law


def _is_possible(law: Any) -> Any:
    if isinstance(law, ByVolume):
        require_dimension(3, "a friction that follows from the volume of the release")
        return law
    return rasters_exist(law)


Law = Annotated[FrictionLaw | ByVolume, GROUND_LAWS.member(ByVolume), AfterValidator(_is_possible)]

Friction = Annotated[Annotated[NonNegative, NUMBER] | Annotated[Law, TABLE], by_type(NUMBER, TABLE)]
"""Coulomb coefficient [-], or a table."""
