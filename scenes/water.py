"""The table `[water]`: water in the pores of the snow. A component adds a scheme.

    [water]
    scheme = "v_w"
    permeability = 1.0e-8

The density of a material is then that of the dry skeleton, and stresses are effective stresses.
"""

from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal

from pydantic import BeforeValidator, field_validator

from snowmpm.registry import WATER
from snowmpm.scenes.spec import Number, Positive, Spec, refuse
from snowmpm.water.permeability import ICE_DENSITY, LAWS, Permeability, law_of

Border = Literal["drained", "sealed"]


def _known_law(value: Any) -> Any:
    """The value, if its law is one of LAWS; a table without one is a raster."""
    law = value.get("law", "raster") if isinstance(value, dict) else "raster"
    if law not in LAWS:
        raise refuse("must be " + " or ".join(f'"{name}"' for name in LAWS), "law", law)
    return value


KnownPermeability = Annotated[Permeability, BeforeValidator(_known_law)]


class WaterTable(Spec):
    """Base of all tables `[water]`. A table adds its `scheme`."""

    REGISTRIES: ClassVar = (WATER,)
    USUAL: ClassVar[bool] = False
    """whether it is the scheme of a table that names none"""

    if TYPE_CHECKING:  # of every table, its own

        @property
        def scheme(self) -> str: ...


def without_raster(value: Any) -> Any:
    """The permeability, if it is no raster."""
    if law_of(value) == "raster":
        raise refuse("is not for water that moves: a number, or a law", "file", value.file)
    return value


class OwnWater(WaterTable):
    """What water with particles of its own has in common."""

    permeability: KnownPermeability
    """intrinsic permeability [m2]: a number, or a table with law = "calonne" or "kozeny_carman" and grain_size [m]"""
    grain_density: Positive = ICE_DENSITY
    """of the grains [kg/m3]: 1 - density / grain_density of a material is its porosity; ice when missing"""
    grain_size: Positive | None = None
    """diameter of the grains [m], of the part of the drag that grows with the square of the speed (Forchheimer); none
    when missing"""
    density: Positive = 1000.0
    """of water [kg/m3]"""
    viscosity: Positive = 1.792e-3
    """dynamic viscosity of water [Pa s]; at 0 °C when missing"""
    table: Number | None = None
    """height z of the water table at the start [m]: below it the pressure is hydrostatic, and snow above it is dry"""
    dry: tuple[str, ...] = ()
    """names of bodies without water in their pores"""

    @field_validator("permeability")
    @classmethod
    def _is_of_the_snow(cls, value: Any) -> Any:
        return without_raster(value)


def _usual() -> str | None:
    return next((name for name, table in WATER.items() if table.USUAL), None)


def _known_scheme(value: Any) -> Any:
    """The table, if its scheme is one of WATER."""
    scheme = value.get("scheme", _usual()) if isinstance(value, dict) else _usual()
    if not isinstance(scheme, str) or scheme not in WATER:
        raise refuse("must be " + " or ".join(f'"{name}"' for name in WATER), "scheme", scheme)
    return value


AnyWater = Annotated[WaterTable, WATER.member(usual=_usual), BeforeValidator(_known_scheme)]
