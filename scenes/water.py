"""Water in the pores of the snow, with method = "mpm" or "implicit"; with scheme = "v_w" "mpm", with "seepage"
"sph", with "one_phase" or "two_phase" "depth".

    [water]
    permeability = 1e-9         # m2; or a table: law = "calonne", grain_size = 1e-3
    porosity = 0.6              # of all materials; from their density and that of ice when missing
    pressure = 1.0e4            # Pa, at the start
    surface = "drained"
    sides = { z_min = "drained" }

    [water]
    scheme = "v_w"              # water with a velocity of its own, which leaves the snow; method = "mpm"
    permeability = 1.0e-8
    bulk_modulus = 1e7          # Pa

    [water]
    scheme = "seepage"          # water that seeps through grains at rest; method = "sph"
    permeability = 1.0e-6       # m2
    bulk_modulus = 1e6          # Pa

    [water]
    scheme = "one_phase"
    level = 0.8                 # depth of the water over that of the snow
    excess = 0.9                # 1: liquefied
    consolidation = 0.05        # m2/s

    [water]
    scheme = "two_phase"
    grain_density = 2000.0      # kg/m3
    consolidation = 0.05        # m2/s
    drag = { law = "anderson", terminal_velocity = 1e-3 }

The density of a material is then that of the dry skeleton, and stresses are effective stresses.
"""

from typing import Annotated, Any, ClassVar, Literal

from pydantic import BeforeValidator, Discriminator, Field, Tag, field_validator, model_validator

from snowmpm.scenes.regions import Region
from snowmpm.scenes.space import AXES, check_file, dimension, require_dimension, tag
from snowmpm.scenes.spec import Fraction, NonNegative, Number, Positive, Spec, refuse
from snowmpm.water.permeability import ICE_DENSITY, LAWS, Permeability

Border = Literal["drained", "sealed"]


def _known_law(value: Any) -> Any:
    """The value, if its law is one of LAWS; a table without one is a raster."""
    law = value.get("law", "raster") if isinstance(value, dict) else "raster"
    if law not in LAWS:
        raise refuse("must be " + " or ".join(f'"{name}"' for name in LAWS), "law", law)
    return value


KnownPermeability = Annotated[Permeability, BeforeValidator(_known_law)]


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
            # A scene that is written out whole names all sides
            if name[0] not in AXES.get(dimension(), "xyz") and getattr(self, name) != "sealed":
                raise refuse(f"a {dimension()}-D scene has no {name[0]}", name, getattr(self, name))
        return self


class SeepingWater(Spec):
    """Water that fills the pores, or a part of them, and flows through them."""

    scheme: Literal["u_p"] = "u_p"
    """u_p: one velocity and a pore pressure; water moves through the skeleton by Darcy's law"""
    split: Literal["semi_implicit", "explicit", "monolithic", "fixed_stress"] = "semi_implicit"
    """semi_implicit: the step is that of the drained skeleton; explicit: it must follow waves in undrained snow, for
    comparison. method = "implicit" has monolithic: skeleton and water are solved for at once; fixed_stress: in turn,
    until both fit"""
    alpha: Positive = 1.0
    """fixed_stress: the skeleton's assumed answer to a change of pressure, over 1 / K_dr of equal compression along all
    axes of the scene [-]; below a half of the true one it does not settle"""
    tolerance: Annotated[Number, Field(ge=1e-12, le=1e-2)] = 1e-6
    """fixed_stress: water left without place over that of the first pass [-] at which a step is solved"""
    iterations: Annotated[int, Field(strict=True, ge=1, le=10_000)] = 100
    """fixed_stress: passes in a step at most; one that takes more is made in halves"""
    permeability: KnownPermeability
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
        if self.solved and self.suction is not None:
            raise refuse(f'does not go with split = "{self.split}", which needs pores that are always full', "suction",
                         self.suction)
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

    @property
    def solved(self) -> bool:
        """Whether the pressure is among the unknowns of the method's steps."""
        return self.split in ("monolithic", "fixed_stress")

    @property
    def NEEDS(self) -> str:
        """Capability of the method."""
        return "solved_water" if self.solved else "water"

    def drained(self, dimension: int) -> dict[str, bool]:
        """Whether each border lets water out, by name (`snowmpm.water.outlets`)."""
        sides = {f"{axis}_{end}": getattr(self.sides, f"{axis}_{end}") for axis in AXES[dimension]
                 for end in ("min", "max")}
        kinds = {"surface": self.surface, "ground": self.ground, "obstacles": self.obstacles, **sides}
        return {name: kind == "drained" for name, kind in kinds.items()}


class _OwnWater(Spec):
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
        return _no_raster(value)


class MovingWater(_OwnWater):
    """Water with particles and a velocity of its own beside the grains: it runs through the pores, leaves the snow and
    pools; method = "mpm" only."""

    NEEDS: ClassVar = "two_velocities"

    scheme: Literal["v_w"]
    """v_w: grains and water have a velocity each, v and w, with drag between them; explicit"""
    bulk_modulus: Positive = 2.2e9
    """K_w of water [Pa]. The step follows its waves: 100 times the largest pressure is enough for flow, and keeps
    compression below 1 %"""
    pressure: NonNegative = 0.0
    """pressure at the start [Pa], without table"""

    @model_validator(mode="after")
    def _goes_together(self):
        if self.table is not None and self.pressure != 0.0:
            raise refuse("does not go with table, which gives the pressure", "pressure", self.pressure)
        return self


class SeepageWater(_OwnWater):
    """Water with particles of its own that seeps through grains at rest, leaves them and pools; method = "sph" only."""

    NEEDS: ClassVar = "seepage"

    scheme: Literal["seepage"]
    """seepage: grains stay where they are; the pressure of the water is solved for in each step"""
    bulk_modulus: Positive = 1e6
    """K_w of water [Pa], which sets no step: 100 times the largest pressure keeps compression below 1 %, and 1000 times
    makes the pressure of single particles noisy"""


def _no_raster(value):
    if getattr(value, "law", None) == "raster":
        raise refuse("is not for water that moves: a number, or a law", "file", value.file)
    return value


class _Flowing(Spec):
    """What depth-averaged flows with water have in common."""

    NEEDS: ClassVar = "flow_water"

    density: Positive = 1000.0
    """of water [kg/m3]"""
    excess: Fraction = 0.0
    """pore pressure at the ground at the start, beyond the hydrostatic one, over the weight that the grains would bear
    without it [-]; 1: liquefied"""
    consolidation: NonNegative
    """c_v = K E / mu at which excess pressure drains [m2/s], with the permeability K, the stiffness E of the skeleton
    for compression to one side and the viscosity mu of water; 0: never"""
    ground: Border = "sealed"
    """drained: no excess pressure at the ground"""
    drains: tuple[Region, ...] = ()
    """regions in plan where the ground is drained, beside what ground says"""
    layers: Annotated[int, Field(strict=True, ge=4, le=100)] = 10
    """of the mesh over the depth of the water"""

    @model_validator(mode="after")
    def _is_3d(self):
        require_dimension(3, "water in a flow over a terrain")
        return self


class FlowingWater(_Flowing):
    """Water that moves with the snow of a depth-averaged flow, and takes a part of its weight off the ground; method =
    "depth" only."""

    scheme: Literal["one_phase"]
    """one_phase: water moves with the snow, but for the excess pressure that drains over the depth"""
    porosity: Annotated[Number, Field(gt=0.0, lt=1.0)] | None = None
    """share of the pores [-]; 1 - density / 917 of each material when missing"""
    level: Annotated[Number, Field(gt=0.0, le=1.0)] = 1.0
    """depth of the water over that of the snow [-]; snow above it is dry"""


class DarcyDrag(Spec):
    """C = n² mu / K of the porosity n."""

    law: Literal["darcy"]
    permeability: KnownPermeability
    """K [m2]: a number, or a table with law = "calonne" or "kozeny_carman" and grain_size [m]"""
    viscosity: Positive = 1.792e-3
    """mu of water [Pa s]; at 0 °C when missing"""

    @field_validator("permeability")
    @classmethod
    def _moves(cls, value: Any) -> Any:
        return _no_raster(value)


class AndersonDrag(Spec):
    """C = n (1 - n) (rho_s - rho_w) g / (V_T n^m) of the porosity n."""

    law: Literal["anderson"]
    terminal_velocity: Positive
    """V_T at which a single grain sinks [m/s]"""
    power: NonNegative = 1.0
    """m [-]"""


class MixedWater(_Flowing):
    """Water and grains of a depth-averaged flow, each with columns of its own, which fill its depth together; method =
    "depth" only."""

    scheme: Literal["two_phase"]
    """two_phase: water and grains have a velocity each, with drag between them"""
    grain_density: Positive
    """of the grains [kg/m3], above that of water; 1 - density / grain_density of a material is its porosity"""
    drag: Annotated[DarcyDrag | AndersonDrag, Field(discriminator="law")]
    """between water and grains"""


SCHEMES = ("u_p", "v_w", "seepage", "one_phase", "two_phase")


def _known_scheme(value: Any) -> Any:
    """The table, if its scheme is one of SCHEMES; without one it is the first."""
    scheme = value.get("scheme", SCHEMES[0]) if isinstance(value, dict) else SCHEMES[0]
    if scheme not in SCHEMES:
        raise refuse("must be " + " or ".join(f'"{name}"' for name in SCHEMES), "scheme", scheme)
    return value


def _which(value: Any) -> str:
    return tag(value.get("scheme", SCHEMES[0]) if isinstance(value, dict) else getattr(value, "scheme", SCHEMES[0]))


Water = Annotated[
    Annotated[Annotated[SeepingWater, Tag(tag("u_p"))] | Annotated[MovingWater, Tag(tag("v_w"))]
              | Annotated[SeepageWater, Tag(tag("seepage"))]
              | Annotated[FlowingWater, Tag(tag("one_phase"))] | Annotated[MixedWater, Tag(tag("two_phase"))],
              Discriminator(_which)],
    BeforeValidator(_known_scheme)]
