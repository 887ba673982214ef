"""Water in the pores of the snow.

    [water]
    permeability = 1e-9         # m2; or a table: law = "calonne", grain_size = 1e-3
    porosity = 0.6              # of all materials; from their density and that of ice when missing
    pressure = 1.0e4            # Pa, at the start
    surface = "drained"
    sides = { z_min = "drained" }

The density of a material is then that of the dry skeleton, and stresses are effective stresses.
"""

from typing import Annotated, Any, Literal

from pydantic import Field, field_validator, model_validator

from snowmpm.scenes.space import AXES, check_file, dimension, require_dimension
from snowmpm.scenes.spec import Fraction, NonNegative, Number, Positive, Spec, refuse
from snowmpm.water.permeability import Permeability

Border = Literal["drained", "sealed"]


class WaterSides(Spec):
    """Whether water leaves through the sides of the domain."""

    x_min: Border = "sealed"
    x_max: Border = "sealed"
    y_min: Border = "sealed"
    y_max: Border = "sealed"
    z_min: Border = "sealed"
    z_max: Border = "sealed"

    @model_validator(mode="after")
    def _fit_the_scene(self):
        for name in sorted(self.model_fields_set):
            if name[0] not in AXES.get(dimension(), "xyz"):
                raise refuse(f"a {dimension()}-D scene has no {name[0]}", name, getattr(self, name))
        return self


class Water(Spec):
    """Water that fills the pores, or a part of them, and flows through them."""

    scheme: Literal["u_p"] = "u_p"
    """u_p: one velocity and a pore pressure; water moves through the skeleton by Darcy's law"""
    split: Literal["semi_implicit", "explicit"] = "semi_implicit"
    """semi_implicit: the step is that of the drained skeleton; explicit: it must follow waves in undrained snow, for
    comparison"""
    permeability: Permeability
    """intrinsic permeability [m2]: a number, a raster { file = "..." }, or a table with law = "calonne" (snow) or
    "kozeny_carman" (grains) and grain_size [m]; times 5.5e6 it is the hydraulic conductivity at 0 °C [m/s]"""
    porosity: Annotated[Number, Field(gt=0.0, lt=1.0)] | None = None
    """share of the pores at the start [-]; 1 - density / 917 of each material when missing"""
    density: Positive = 1000.0
    """of water [kg/m3]"""
    bulk_modulus: Positive = 2.2e9
    """of water [Pa]"""
    viscosity: Positive = 1.792e-3
    """dynamic viscosity of water [Pa s]; at 0 °C when missing"""
    pressure: Number = 0.0
    """pore pressure at the start [Pa]"""
    table: Number | None = None
    """height z of the water table at the start [m]: below it the pressure is hydrostatic; replaces pressure"""
    saturation: Fraction = 1.0
    """share of the pores that water fills at the start, above the table if there is one [-]; below 1 needs suction"""
    suction: NonNegative | None = None
    """largest suction that pores hold before air enters [Pa], 0 for coarse snow; when missing, pores are always full"""
    surface: Border = "drained"
    """the free surface; drained: p = 0 there"""
    ground: Border = "sealed"
    """the terrain"""
    obstacles: Border = "sealed"
    """obstacles"""
    sides: WaterSides = WaterSides()
    """sides of the domain"""

    @field_validator("permeability")
    @classmethod
    def _raster_is_there(cls, value: Any) -> Any:
        if getattr(value, "law", None) == "raster":
            require_dimension(3, "a raster of permeability")
            check_file(value.file, "file")
        return value

    @model_validator(mode="after")
    def _goes_together(self):
        if self.saturation < 1.0 and self.suction is None:
            raise refuse("below 1 needs suction, the largest that pores hold before air enters", "saturation",
                         self.saturation)
        if self.table is not None and self.pressure != 0.0:
            raise refuse("does not go with table, which gives the pressure", "pressure", self.pressure)
        if self.suction is not None and self.pressure < -self.suction:
            raise refuse(f"must be >= -suction = {-self.suction:g}", "pressure", self.pressure)
        if self.saturation < 1.0 and self.table is None and self.pressure > 0.0:
            raise refuse("needs pores that are full: saturation = 1", "pressure", self.pressure)
        return self

    def drained(self, dimension: int) -> dict[str, bool]:
        """Whether each border lets water out, by name (`snowmpm.water.outlets`)."""
        sides = {f"{axis}_{end}": getattr(self.sides, f"{axis}_{end}") for axis in AXES[dimension]
                 for end in ("min", "max")}
        kinds = {"surface": self.surface, "ground": self.ground, "obstacles": self.obstacles, **sides}
        return {name: kind == "drained" for name, kind in kinds.items()}
