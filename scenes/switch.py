"""Hand-over of a scene from one method to another while it runs.

    [[switch]]
    to = "depth"            # method that takes over
    when = "flowing"        # half of the mass is faster than 5 m/s; or "t > 8", "broken", "reached"
    [switch.solver]
    dx = 5.0                # m
"""

import re
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field, field_validator, model_validator

from snowmpm.methods import METHODS
from snowmpm.scenes.friction import Friction
from snowmpm.scenes.friction_cards import with_friction_card
from snowmpm.scenes.numerics import Solver
from snowmpm.scenes.regions import Region
from snowmpm.scenes.spec import Fraction, Positive, Spec, one_of, refuse

FLOWING, BROKEN, REACHED = "flowing", "broken", "reached"
TIME = re.compile(r"t\s*>\s*(\d+(?:\.\d*)?(?:[eE][-+]?\d+)?)$")
SHARES = {FLOWING: 0.5, BROKEN: 0.9, REACHED: 0.0}
"""Share of the mass, or of the particles with bonds, of a scene that gives none."""


def _takers():
    """Methods that take over: of those that solve for their steps, none."""
    return [name for name, entry in METHODS.items() if not entry.capabilities.solves]


class Switch(Spec):
    """Another method takes over with all the snow, once the events of the scene are over."""

    EXAMPLES: ClassVar = {"share": 0.5}

    to: Annotated[str, one_of(_takers)]
    """method that takes over; "depth" after a method of particles in space, or one of these after "depth" """
    when: Annotated[str, Field(strict=True, max_length=40)] = FLOWING
    """"t > 8": a time [s]; "flowing": a share of the mass is faster than a speed; "broken": a share of the particles
    with bonds (a weak layer) has lost them; "reached": more than a share of the mass lies in a region"""
    speed: Positive = 5.0
    """flowing: the speed [m/s]"""
    share: Fraction | None = None
    """share of the mass of when [-]. When missing, flowing: 0.5; broken: 0.9; reached: 0, so that the first column
    counts"""
    region: Region | None = None
    """reached: where, in plan"""
    friction: Friction | None = None
    """coefficient or law of the ground's friction from then on [-], as in terrain; that of the terrain when missing"""
    at_rest: Literal["flows", "stays"] = "flows"
    """stays: snow slower than 1 m/s is taken out and counted (taken_mass); flows: it goes on as all other"""
    solver: Solver
    """solver of the method that takes over: at least dx"""

    @model_validator(mode="before")
    @classmethod
    def _names_its_method(cls, data: Any) -> Any:
        if isinstance(data, dict) and isinstance(data.get("solver"), dict):
            method = data["solver"].get("method", data.get("to"))
            if method != data.get("to"):
                raise refuse(f"is what to names: {data.get('to')}; leave it out", "solver.method", method)
            return {**data, "solver": {**data["solver"], "method": method}}
        return data

    @field_validator("when")
    @classmethod
    def _is_a_moment(cls, when: str) -> str:
        if when not in SHARES and not TIME.match(when):
            raise refuse('must be "t > " and a time [s], or one of ' + ", ".join(f'"{name}"' for name in SHARES))
        return when

    @model_validator(mode="after")
    def _has_its_region(self) -> "Switch":
        if (self.when == REACHED) != (self.region is not None):
            raise refuse('when = "reached" and region belong together', "region", self.when)
        return self

    @property
    def time(self) -> float | None:
        """Time of the hand-over [s]; None where it follows from the snow."""
        found = TIME.match(self.when)
        return float(found[1]) if found else None

    @property
    def least_share(self) -> float:
        """`share`, or what stands for it."""
        return SHARES.get(self.when, 0.0) if self.share is None else self.share


def with_switches(data: Any) -> Any:
    """Tables of a scene whose switches have its precision and the numbers of their friction cards; the data given
    stays as it is."""
    switches = data.get("switch") if isinstance(data, dict) else None
    if not isinstance(switches, list | tuple):
        return data
    solver = data.get("solver")
    common = {"precision": solver["precision"]} if isinstance(solver, dict) and "precision" in solver else {}
    return {**data, "switch": [_completed(switch, common) for switch in switches]}


def _completed(switch, common):
    if not isinstance(switch, dict):
        return switch
    if "friction" in switch:
        terrain = with_friction_card({"terrain": {"friction": switch["friction"]}})["terrain"]
        switch = {**switch, "friction": terrain["friction"]}
    if isinstance(switch.get("solver"), dict):
        switch = {**switch, "solver": {**common, **switch["solver"]}}
    return switch


def parts(scene: Any) -> list[Any]:
    """The scene of each method that computes a `Scene`, one after the other: the first is the scene itself, the others
    have the solver and the friction of a switch."""
    found = [scene]
    for switch in scene.switch:
        terrain = scene.terrain
        if switch.friction is not None and terrain is not None:
            terrain = terrain.model_copy(update={"friction": switch.friction})
        found.append(scene.model_copy(update={"solver": switch.solver, "terrain": terrain}))
    return found
