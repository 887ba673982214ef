"""Plan regions of layers."""

from typing import Annotated, Any, ClassVar

from pydantic import Discriminator, Field, Tag, model_validator

from snowmpm.scenes.space import FileName, Interval, Pair, require_dimension, tag
from snowmpm.scenes.spec import Spec, refuse


class PlanBox(Spec):
    """Bounds in plan; a missing one leaves that axis free."""

    x: Interval | None = None
    """[lower, upper] [m]"""
    y: Interval | None = None
    """[lower, upper] [m]; 3-D only"""

    @model_validator(mode="after")
    def _bounds_something(self):
        if self.x is None and self.y is None:
            raise refuse("needs x = [lower, upper], y = [lower, upper] or both")
        if self.y is not None:
            require_dimension(3, "y")
        return self


class PlanPolygon(Spec):
    """A polygon in plan (3-D)."""

    EXAMPLES: ClassVar = {"polygon": [[0.0, 0.0], [40.0, 0.0], [20.0, 30.0]]}

    polygon: Annotated[tuple[Pair, ...], Field(min_length=3)]
    """corners [x, y] [m]"""

    @model_validator(mode="after")
    def _is_3d(self):
        require_dimension(3, "a polygon in plan")
        return self


class PlanFile(Spec):
    """Polygons of a shapefile or GeoJSON, in the terrain's coordinates (3-D)."""

    file: FileName
    """.shp, .geojson or .gpkg file, relative to the scene file"""

    @model_validator(mode="after")
    def _is_3d(self):
        require_dimension(3, "a region from a file")
        return self


def _which(value: Any) -> str:
    keys = value if isinstance(value, dict) else ()
    for mark, table in (("polygon", PlanPolygon), ("file", PlanFile)):
        if isinstance(value, table) or mark in keys:
            return tag(mark)
    return tag("box")


Region = Annotated[
    Annotated[PlanBox, Tag(tag("box"))]
    | Annotated[PlanPolygon, Tag(tag("polygon"))]
    | Annotated[PlanFile, Tag(tag("file"))],
    Discriminator(_which),
]
