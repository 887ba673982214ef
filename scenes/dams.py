"""Dams on the ground: ridges along lines in plan, which deflect a flow, hold it back, or are overtopped."""

from typing import Annotated, Any, ClassVar

from pydantic import Field, model_validator

from snowmpm.scenes.space import FileName, Pair
from snowmpm.scenes.spec import NonNegative, Number, Positive, Spec, refuse


class Dam(Spec):
    """A ridge that follows a line."""

    EXAMPLES: ClassVar = {
        "name": "catching dam",
        "line": [[120.0, 40.0], [120.0, 90.0]],
        "height": 8.0,
        "crest_width": 5.0,
        "file": "dam.shp",
    }

    name: Annotated[str, Field(min_length=1)]
    """in maps and tables"""
    line: Annotated[tuple[Pair, ...], Field(min_length=2)] | None = None
    """corners [x, y] of its crest, in the terrain's coordinates [m]; first and last alike for a ring"""
    file: FileName | None = None
    """in place of line: lines of a .shp, .geojson or .gpkg file, a dam for each"""
    line_source: str | None = None
    """file of the line, in the scene of a run"""
    height: Positive
    """of the crest above the ground under it [m]"""
    slope: Annotated[Number, Field(ge=10.0, le=85.0)] = 45.0
    """of its sides [degrees]"""
    crest_width: NonNegative = 0.0
    """width of its top [m]"""

    @model_validator(mode="after")
    def _is_a_line(self) -> Any:
        from shapely import LineString  # slow to import

        if self.line is None:
            raise refuse("is missing: corners [x, y] of its crest [m], or file", "line")
        for i, (before, after) in enumerate(zip(self.line, self.line[1:], strict=False)):
            if before == after:
                raise refuse("repeats the point before", f"line.{i + 1}", after)
        if not LineString(self.line).is_simple:
            raise refuse("crosses itself", "line", [list(point) for point in self.line])
        return self
