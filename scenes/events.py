"""Events that act on a body, or on the water in the snow, at a given time: a saw cut, a load, a removal, rain, melt, a
border that begins to drain."""

from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field, model_validator

from snowmpm.registry import EVENTS
from snowmpm.scenes.regions import PlanBox
from snowmpm.scenes.space import Vector, require_dimension
from snowmpm.scenes.spec import NonNegative, Positive, Spec, check_period, refuse
from snowmpm.water.melting import melt_rate


class Event(Spec):
    """Base of all tables of events. A table adds its `kind`, NEEDS and ACTS."""

    REGISTRIES: ClassVar = (EVENTS,)
    NEEDS: ClassVar[str] = ""
    """what a method must be capable of (`snowmpm.methods.Capabilities`)"""
    OF: ClassVar[str] = ""
    """table of the scene whose component it acts on, if it does (`snowmpm.components.contract.Component.events`)"""
    ACTS: ClassVar[Any]
    """what it does in a run: "module:name" of a callable, or the callable itself, that is given the table, the number
    of the body that it names, or None, and dx [m], and returns a `running.event.Event`"""


@EVENTS.add
class Cut(Event):
    """A saw cut through a body along a path: material on the path loses its cohesion."""

    NEEDS: ClassVar = "cuts"
    ACTS: ClassVar = "snowmpm.running.events:Cut"
    kind: Literal["cut"]
    body: str
    """name of the body that is cut"""
    start: NonNegative = 0.0
    """when it begins [s]"""
    path: Annotated[tuple[Vector, ...], Field(min_length=2)]
    """corners of the saw's path [m]"""
    speed: Positive | None = None
    """speed of the saw along its path [m/s]; the whole path at once when missing"""
    width: Positive | None = None
    """width of the cut across its path [m]; the thickness that the grid resolves when missing"""


@EVENTS.add
class Load(Event):
    """A force on a part of a body around a point, such as the weight of a skier, or on all of it, such as new snow."""

    NEEDS: ClassVar = "loads"
    ACTS: ClassVar = "snowmpm.running.events:load"
    kind: Literal["load"]
    body: str
    """name of the body that is loaded"""
    start: NonNegative = 0.0
    """when it begins [s]"""
    stop: Positive | None = None
    """[s]; never when missing"""
    ramp: NonNegative = 0.0
    """time in which the force ramps up from zero [s]"""
    centre: Vector | None = None
    """of the part that is loaded [m]; the whole body when missing"""
    radius: Positive | None = None
    """of that part [m]"""
    force: Vector
    """total force [N]; in 2-D per metre of width [N/m]. With a centre, of the snow that is there when the load starts:
    snow and water that come in later are accelerated alike"""

    @model_validator(mode="after")
    def _ends_after_it_starts(self):
        check_period(self.start, self.stop)
        return self

    @model_validator(mode="after")
    def _is_somewhere(self):
        if (self.centre is None) != (self.radius is None):
            raise refuse("needs both centre and radius, or neither: the whole body")
        return self


@EVENTS.add
class Remove(Event):
    """Removal of a body, such as a support."""

    NEEDS: ClassVar = "removal"
    ACTS: ClassVar = "snowmpm.running.events:Remove"
    kind: Literal["remove"]
    body: str
    """name of the body that is removed"""
    start: NonNegative = 0.0
    """when it begins [s]"""


class _Wetting(Event):
    """Water that comes to the surface of the snow for a while."""

    OF: ClassVar = "water"
    ACTS: ClassVar = "snowmpm.running.water_events:Wetting"
    start: NonNegative = 0.0
    """when it begins [s]"""
    stop: Positive | None = None
    """[s]; never when missing"""
    region: PlanBox | None = None
    """where it falls; everywhere when missing"""

    @model_validator(mode="after")
    def _ends_after_it_starts(self):
        check_period(self.start, self.stop)
        return self


@EVENTS.add
class Rain(_Wetting):
    """Rain, which the surface of the snow takes up; what it cannot hold runs off."""

    kind: Literal["rain"]
    rate: Positive
    """mass of water per plan area and time [kg/m2/s]: 1 mm/h is 2.8e-4"""


@EVENTS.add
class Melt(_Wetting):
    """Melt of the surface of the snow by a flux of energy E: water of the mass E / L per plan area and time, L =
    `snowmpm.water.melting.LATENT_HEAT`, comes to the highest snow of each column. The grains keep their mass: what has
    melted must be little of what they hold. The snow is at 0 °C; nothing freezes again."""

    kind: Literal["melt"]
    energy_flux: Positive
    """that melts, per plan area: what the surface gains by radiation, air and rain [W/m2]; 100 W/m2 melt 1.1 mm/h"""

    @property
    def rate(self) -> float:
        """mass of water per plan area and time [kg/m2/s]"""
        return melt_rate(self.energy_flux)


@EVENTS.add
class Drainage(Event):
    """A border lets water out from now on, or no more."""

    OF: ClassVar = "water"
    ACTS: ClassVar = "snowmpm.running.water_events:Drainage"
    kind: Literal["drainage"]
    border: Literal["surface", "ground", "obstacles", "x_min", "x_max", "y_min", "y_max", "z_min", "z_max"]
    """the free surface, the terrain, obstacles or a side of the domain"""
    becomes: Literal["drained", "sealed"]
    """drained: p = 0 there"""
    start: NonNegative = 0.0
    """when it begins [s]"""

    @model_validator(mode="after")
    def _has_that_side(self):
        if self.border.startswith("y_"):
            require_dimension(3, f"the border {self.border}")
        return self


AnyEvent = Annotated[Event, EVENTS.member()]
