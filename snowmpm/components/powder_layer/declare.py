"""A powder layer above a depth-averaged flow: its table, and what it does not go with.

    [powder_layer]
    air_entrainment = "parker_1986"         # or "parker_1987", "none"
    suspension = "speed"                    # or "shear_excess", "none"
    suspension_rate = 1e-3
    grain_diameter = 2e-4                   # m
"""

from collections.abc import Iterable
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field

from snowmpm import components
from snowmpm.components.contract import Component
from snowmpm.errors import InputError
from snowmpm.registry import COMPONENTS
from snowmpm.scenes.spec import NonNegative, Number, Spec

EXPERIMENT = "an experiment: no measured profile of pressure or velocity was compared with it"
"""What is said wherever its results are."""


class PowderLayer(Spec):
    """A dilute cloud above the flow, an experiment; method = "depth" by finite volumes only."""

    EXAMPLES: ClassVar = {"fall_speed": 0.5, "suspension_rate": 1e-3}

    profile: Literal["uniform", "motpsa"] = "uniform"
    """how speed and concentration go with the height, by factors of the fluxes"""
    air_entrainment: Literal["parker_1986", "parker_1987", "none"] = "parker_1986"
    """how fast the cloud takes in air, by its Richardson number"""
    suspension: Literal["speed", "shear_excess", "none"] = "speed"
    """how fast snow goes from the flow into the cloud; chosen, not measured"""
    suspension_rate: NonNegative | None = None
    """of that law [-]; 1e-3 of "speed", 1 of "shear_excess" when missing"""
    suspension_stress: NonNegative = 10.0
    """tau_c of "shear_excess" [Pa]"""
    grain_diameter: Annotated[Number, Field(ge=1e-5, le=2e-3)] = 2e-4
    """of the grains, whose fall speed follows from it [m]"""
    fall_speed: NonNegative | None = None
    """of the grains, in place of that of their diameter [m/s]; 0: nothing falls out"""
    bed_concentration: Literal["parker_1986", "uniform"] = "parker_1986"
    """concentration at the bed over the mean, by which grains fall out"""
    cover_load: NonNegative = 0.0
    """snow cover that the cloud may take up by itself, normal to the ground [kg/m2]; 0: none"""
    cover_rate: NonNegative = 1.0
    """k of the law of the snow cover [-]; chosen, not measured"""
    cover_stress: NonNegative = 10.0
    """tau_s of it [Pa]"""
    ground_drag: NonNegative = 0.008
    """C_02 of the stress C rho u^2 on the ground, where no flow moves under the cloud [-]"""
    core_drag: NonNegative = 0.04
    """C_12 of the stress C rho (u_1 - u_2)^2 between flow and cloud [-]"""
    top_drag: NonNegative = 1e-4
    """C of the stress C rho u^2 at the top [-]"""
    front_drag: NonNegative = 0.5
    """k of the resistance of the air ahead, k rho_a d(h u)/dt where the cloud grows [-]; a front in air has a Froude
    number of 1 / sqrt(2 k)"""


class OfScene(Spec):
    """Keys of a scene."""

    powder_layer: PowderLayer | None = None
    """a dilute cloud above the flow, an experiment; none when missing"""


def asked(scene: Any) -> Iterable[tuple[str, object]]:
    """(key, value) of the table."""
    if scene.powder_layer:
        yield "powder_layer", "a table"


def refuse(scene: Any) -> None:
    """Raise InputError where columns compute the flow, and for two covers."""
    if scene.solver.in_plan and not scene.solver.in_volumes:
        raise InputError.at("powder_layer", "a table", "does not go with solver.depth.scheme ="
                            ' "columns": its cells lie over those of "volumes"', scene.source)
    keys = [key for other in components.used(scene) for key, _ in other.asked(scene)]
    if scene.powder_layer.cover_load > 0.0 and any(key.startswith("terrain.entrainment") for key in keys):
        raise InputError.at("powder_layer.cover_load", scene.powder_layer.cover_load, "does not go with"
                            " terrain.entrainment: both would take up one snow cover", scene.source)


def told(scene: Any) -> dict[str, str]:
    """That it is an experiment."""
    return {"powder layer": EXPERIMENT}


COMPONENTS.add(Component(
    "powder_layer", __package__, "powder layer", asked, order=60, keys={"scene": OfScene},
    adapters={"depth": f"{__package__}.volumes:adapter"}, beside=("switch", "zone", "saw_test"), refuse=refuse,
    told=told, cautions=f"{__package__}.cautions", atlas=f"{__package__}.atlas"))
