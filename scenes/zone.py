"""A region in which a depth-averaged flow is computed in three dimensions, at the same time and in the same run.

    [zone]
    region = { x = [24.0, 40.0], y = [0.0, 20.0] }
    [zone.solver]
    dx = 0.5                # m; method = "mpm"
"""

from typing import Any

from pydantic import model_validator

from snowmpm.methods import who_can
from snowmpm.scenes.numerics import Solver
from snowmpm.scenes.regions import Region
from snowmpm.scenes.spec import Spec, refuse


class Zone(Spec):
    """Columns that flow into the region become particles, and particles that flow out of it columns."""

    region: Region
    """where, in plan, in whole cells of solver.dx: around an obstacle, from six of these cells before it on"""
    solver: Solver
    """solver of the method in the region: at least dx; method = "mpm" when missing"""

    @model_validator(mode="before")
    @classmethod
    def _usual_method(cls, data: Any) -> Any:
        if isinstance(data, dict) and isinstance(data.get("solver"), dict) and "method" not in data["solver"]:
            return {**data, "solver": {"method": who_can("within_zone")[0], **data["solver"]}}
        return data

    @model_validator(mode="after")
    def _steps_with_the_flow(self) -> "Zone":
        if self.solver.dt is not None:
            raise refuse("is chosen as the flow asks: leave it out", "solver.dt", self.solver.dt)
        return self


def with_zone(data: Any) -> Any:
    """Tables of a scene whose zone has its precision; the data given stays as it is."""
    zone, solver = (data.get(name) if isinstance(data, dict) else None for name in ("zone", "solver"))
    if not (isinstance(zone, dict) and isinstance(zone.get("solver"), dict) and isinstance(solver, dict)
            and "precision" in solver):
        return data
    return {**data, "zone": {**zone, "solver": {"precision": solver["precision"], **zone["solver"]}}}


def within(scene: Any) -> Any:
    """The scene of the method in the zone of a `Scene`: with the zone's solver."""
    return scene.model_copy(update={"solver": scene.zone.solver, "zone": None})
