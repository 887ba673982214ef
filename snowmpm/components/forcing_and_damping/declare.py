"""Accelerations, pressures, damping and gravity that changes: their tables, and which methods take them."""

from typing import Annotated, ClassVar, Literal

from pydantic import Field

from snowmpm.components.contract import Component
from snowmpm.errors import InputError
from snowmpm.registry import COMPONENTS, FORCES
from snowmpm.scenes.forces import Space, Timed, Value, Valued
from snowmpm.scenes.gravity import Gravity
from snowmpm.scenes.regions import Region
from snowmpm.scenes.space import FileName
from snowmpm.scenes.spec import Positive, Spec

IN_TIME = ("mpm", "sph")
"""Methods whose steps take damping, and gravity that changes."""


@FORCES.add
class Acceleration(Valued):
    """A force in proportion to mass: wind drag, shaking, the pull of a magnet."""

    EXAMPLES: ClassVar = {"file": "wind.csv"}

    ACTS: ClassVar = f"{__package__}.fields:Acceleration"
    UNIT: ClassVar = "m/s2"
    kind: Literal["acceleration"]
    value: Annotated[tuple[Value, ...], Field(min_length=2, max_length=3)] | None = None
    """[m/s2]: a number or a formula of x, y, z, t and the velocity vx, vy, vz of the snow, one an axis"""
    file: FileName | None = None
    """table (.csv) on a grid in space and time, in place of the value: time, x, y, z (those that it depends on), then
    ax, ay, az"""
    body: str | None = None
    """name of the body that it acts on; all when missing"""
    within: Space | None = None
    """where it acts: a block; everywhere when missing"""
    region: Region | None = None
    """where it acts, in plan; everywhere when missing"""

    def places(self):
        return [*([f"on {self.body}"] if self.body else []), *(["in within"] if self.within else []),
                *(["in region"] if self.region else [])]


@FORCES.add
class Pressure(Valued):
    """The pressure of a fluid around the snow or in its pores."""

    EXAMPLES: ClassVar = {"file": "cell_pressure.csv"}

    ACTS: ClassVar = f"{__package__}.fields:Pressure"
    kind: Literal["pressure"]
    acts_on: Literal["surface", "pores"] = "surface"
    """surface: on the free surface of the snow, as of a cell or a lake around it; pores: on each volume by the gradient
    alone, as of water that seeps through the snow; stresses are then effective stresses"""
    value: Value | None = None
    """[Pa]: a number or a formula of x, y, z and t; inside the snow any smooth continuation is right"""
    file: FileName | None = None
    """table (.csv) on a grid in space and time, in place of the value: time, x, y, z (those that it depends on), then
    pressure"""

    def places(self):
        return ["around the snow" if self.acts_on == "surface" else "in its pores"]


class Damping(Timed):
    """A drag on every particle in proportion to its mass: dv/dt = ... - coefficient v."""

    EXAMPLES: ClassVar = {"rest_speed": 0.01}

    coefficient: Positive
    """[1/s]: free motion decays to a third in 1.1 / coefficient seconds"""
    rest_speed: Positive | None = None
    """damping ends for good once the fastest particle, having been faster, falls below this speed [m/s]"""


class OfScene(Spec):
    """Keys of a scene."""

    damping: Damping | None = None
    """a drag on every particle; none when missing"""


def in_time(scene):
    """(key, value) of gravity that changes and of damping."""
    if isinstance(scene.gravity, Gravity):
        yield "gravity", "a table"
    if scene.damping:
        yield "damping.coefficient", scene.damping.coefficient


def asked(scene):
    """(key, value) of what acts."""
    yield from in_time(scene)
    for i, force in enumerate(scene.forces):
        if force.ACTS is not None:
            yield f"forces.{i}.kind", force.kind


def told(scene):
    """What acts, in words."""
    if not scene.damping:
        return {}
    ends = f", ends at rest ({scene.damping.rest_speed:g} m/s)" if scene.damping.rest_speed else ""
    return {"damping": f"{scene.damping.coefficient:g} 1/s{scene.damping.when}{ends}"}


def refuse(scene):
    """Raise InputError for damping and gravity that changes in steps that do not take them."""
    if scene.solver.method not in IN_TIME:
        allowed = " or ".join(f'"{name}"' for name in IN_TIME)
        for key, value in in_time(scene):
            raise InputError.at(key, value, f'needs solver.method = {allowed} in place of "{scene.solver.method}"',
                                scene.source)


COMPONENTS.add(Component(
    "forcing_and_damping", __package__, "forces, damping and gravity in time", asked, order=5, keys={"scene": OfScene},
    refuse=refuse, told=told, accelerates=f"{__package__}.acting:accelerate"))
