"""Water in a depth-averaged flow: the table `[water]` with scheme = "one_phase" or "two_phase", and what it does not go
with.

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
"""

from typing import Annotated, Any, Literal

from pydantic import Field, field_validator, model_validator

from snowmpm.components.contract import Component
from snowmpm.errors import InputError
from snowmpm.registry import COMPONENTS, WATER
from snowmpm.scenes.regions import Region
from snowmpm.scenes.space import require_dimension
from snowmpm.scenes.spec import Fraction, NonNegative, Number, Positive, Spec
from snowmpm.scenes.water import Border, KnownPermeability, WaterTable, without_raster
from snowmpm.water.refusals import refuse_hand_over


class _Flowing(WaterTable):
    """What depth-averaged flows with water have in common."""

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


@WATER.add
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
        return without_raster(value)


class AndersonDrag(Spec):
    """C = n (1 - n) (rho_s - rho_w) g / (V_T n^m) of the porosity n."""

    law: Literal["anderson"]
    terminal_velocity: Positive
    """V_T at which a single grain sinks [m/s]"""
    power: NonNegative = 1.0
    """m [-]"""


@WATER.add
class MixedWater(_Flowing):
    """Water and grains of a depth-averaged flow, each with columns of its own, which fill its depth together; method =
    "depth" only."""

    scheme: Literal["two_phase"]
    """two_phase: water and grains have a velocity each, with drag between them"""
    grain_density: Positive
    """of the grains [kg/m3], above that of water; 1 - density / grain_density of a material is its porosity"""
    drag: Annotated[DarcyDrag | AndersonDrag, Field(discriminator="law")]
    """between water and grains"""


def asked(scene):
    """(key, value) of the table."""
    if scene.water is not None and scene.water.scheme in ("one_phase", "two_phase"):
        yield "water.scheme", scene.water.scheme


def refuse_beside(scene):
    """Raise InputError for what does not go with water in a flow."""
    refuse_hand_over(scene)
    if scene.water.scheme == "two_phase" and scene.obstacles:
        raise InputError.at("water.scheme", "two_phase", 'does not go with obstacles: take "one_phase"', scene.source)


COMPONENTS.add(Component(
    "flow_water", __package__, "water in the flow", asked, order=4, owns=("the weight of columns",), beside=("zone",),
    refuse=refuse_beside, fills=f"{__package__}.from_scene:two_phases", laws=f"{__package__}.from_scene:laws"))
