"""Shapes that bodies fill and obstacles have."""

import math
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field, model_validator

from snowmpm.registry import OBSTACLES, SHAPES, Registry
from snowmpm.scenes.regions import PlanFile, Region
from snowmpm.scenes.space import (
    AXES,
    NUMBER,
    TABLE,
    TEXT,
    Direction,
    FileName,
    Interval,
    Pair,
    Vector,
    by_type,
    require_dimension,
)
from snowmpm.scenes.spec import NonNegative, Positive, Spec, refuse

Count = Annotated[int, Field(strict=True, ge=1)]


def check_corners(lower, upper):
    """Raise an error unless the lower corner `min` of a box is below its upper corner `max` along every axis."""
    for axis, low, high in zip(AXES[len(lower)], lower, upper, strict=False):
        if low >= high:
            raise refuse(f"must be above min along every axis, and along {axis} min is {low:g}", "max", upper)


class Shape(Spec):
    """Base of all shapes of bodies. A shape adds its `kind` and FILLS."""

    REGISTRIES: ClassVar[tuple[Registry, ...]] = (SHAPES,)
    DIMENSION: ClassVar[int | None] = None
    """of the only scenes that have it; None: all"""
    FILLS: ClassVar[Any] = None
    """what is filled with particles: "module:name" of a callable, or the callable itself, that is given the table, the
    dimension, the folder of relative files and the table's key, and returns a `seeding.shapes.Shape`"""

    @model_validator(mode="after")
    def _has_its_dimension(self):
        if self.DIMENSION:
            require_dimension(self.DIMENSION, f'shape of kind "{self.kind}"')
        return self

    @property
    def thickness(self) -> float:
        """Least extent [m]; inf where it is not known."""
        return math.inf


class Solid(Shape):
    """Base of all shapes that obstacles have, too. A shape adds SOLID."""

    REGISTRIES: ClassVar = (SHAPES, OBSTACLES)
    SOLID: ClassVar[Any]
    """the rigid shape: as FILLS, returns a `solids.shape.SolidShape`"""
    ON_GROUND: ClassVar[bool] = False
    """whether it is also given the `TerrainSurface` of the scene, or None"""


@SHAPES.add
@OBSTACLES.add
class Box(Solid):
    """A block along the axes; a rectangle in 2-D."""

    FILLS: ClassVar = "snowmpm.seeding.shapes:box"
    SOLID: ClassVar = "snowmpm.solids.shape:box"
    kind: Literal["box"]
    min: Vector
    """lower corner [m]"""
    max: Vector
    """upper corner [m]"""

    @model_validator(mode="after")
    def _corners(self):
        check_corners(self.min, self.max)
        return self

    @property
    def thickness(self) -> float:
        return min(high - low for low, high in zip(self.min, self.max, strict=True))


@SHAPES.add
@OBSTACLES.add
class Sphere(Solid):
    """A ball, a disc in 2-D."""

    FILLS: ClassVar = "snowmpm.seeding.shapes:sphere"
    SOLID: ClassVar = "snowmpm.solids.shape:sphere"
    kind: Literal["sphere"]
    centre: Vector
    """its centre [m]"""
    radius: Positive
    """its radius [m]"""

    @property
    def thickness(self) -> float:
        return 2.0 * self.radius


@SHAPES.add
@OBSTACLES.add
class Cylinder(Solid):
    """A solid cylinder (3-D)."""

    DIMENSION: ClassVar = 3
    FILLS: ClassVar = "snowmpm.seeding.shapes:cylinder"
    SOLID: ClassVar = "snowmpm.solids.shape:cylinder"
    kind: Literal["cylinder"]
    base: Vector
    """centre of the base [m]"""
    axis: Direction
    """direction from the base to the top, of any length [-]"""
    radius: Positive
    """its radius [m]"""
    height: Positive
    """its height along the axis [m]"""

    @property
    def thickness(self) -> float:
        return min(2.0 * self.radius, self.height)


@SHAPES.add
@OBSTACLES.add
class SolidMesh(Solid):
    """The inside of a watertight triangle mesh (3-D)."""

    EXAMPLES: ClassVar = {"file": "statue.stl"}

    DIMENSION: ClassVar = 3
    FILLS: ClassVar = "snowmpm.seeding.shapes:mesh"
    SOLID: ClassVar = "snowmpm.solids.shape:mesh"
    kind: Literal["mesh"]
    file: FileName
    """STL, OBJ or PLY file, relative to the scene file"""


@SHAPES.add
@OBSTACLES.add
class Polygon(Solid):
    """The inside of a polygon in the plane of a 2-D scene."""

    DIMENSION: ClassVar = 2
    FILLS: ClassVar = "snowmpm.seeding.shapes:polygon"
    SOLID: ClassVar = "snowmpm.solids.shape:polygon"
    kind: Literal["polygon"]
    points: Annotated[tuple[Vector, ...], Field(min_length=3)]
    """corners [x, z] [m]"""


@SHAPES.add
class Prism(Shape):
    """A polygon in the plane of x and z, extruded along y (3-D)."""

    DIMENSION: ClassVar = 3
    FILLS: ClassVar = "snowmpm.seeding.shapes:prism"
    kind: Literal["prism"]
    points: Annotated[tuple[Pair, ...], Field(min_length=3)]
    """corners [x, z] [m]"""
    y: Interval
    """[lower, upper] [m]"""


@SHAPES.add
class Voxels(Shape):
    """The voxels of one value in an image, such as the ice of a microstructure."""

    EXAMPLES: ClassVar = {"origin": [0.0, 0.0, 0.0], "counts": [200, 200, 200]}

    FILLS: ClassVar = "snowmpm.seeding.shapes:voxels"
    kind: Literal["voxels"]
    file: FileName
    """image of the scene's dimension: .npy or .npz (indices along x, z or x, y, z), .tif (pages from below), .mhd or
    .mha (MetaImage), .raw (bytes), relative to the scene file"""
    voxel_size: Positive
    """side of a voxel [m]"""
    phase: Annotated[int, Field(strict=True)] = 1
    """value of the voxels that are filled"""
    origin: Vector | None = None
    """lower corner of the image [m]; zero when missing"""
    counts: Annotated[tuple[Count, ...], Field(min_length=2, max_length=3)] | None = None
    """.raw only: voxels along each axis, the first of them fastest"""


@OBSTACLES.add
class Footprint(Shape):
    """An upright solid over an area in plan, such as a building, from below the ground to a flat top (3-D)."""

    REGISTRIES: ClassVar = (OBSTACLES,)
    EXAMPLES: ClassVar = {"file": "buildings.shp", "part": 2, "polygon": [[0.0, 0.0], [10.0, 0.0], [10.0, 8.0]]}
    DIMENSION: ClassVar = 3
    SOLID: ClassVar = "snowmpm.solids.footprint:footprint"
    ON_GROUND: ClassVar = True

    kind: Literal["footprint"]
    file: FileName | None = None
    """polygons of a .shp, .geojson or .gpkg file, relative to the scene file"""
    part: Annotated[int, Field(strict=True, ge=1)] | None = None
    """number of the area in the file, from 1; when missing, each area of the file becomes an obstacle of its own, with
    this number behind its name"""
    polygon: Annotated[tuple[Pair, ...], Field(min_length=3)] | None = None
    """corners [x, y] [m], in place of file"""
    height: Positive
    """of the top above the highest ground under it [m]"""

    @model_validator(mode="after")
    def _is_one_area(self):
        if (self.file is None) == (self.polygon is None):
            raise refuse("needs one of file and polygon")
        if self.part is not None and self.file is None:
            raise refuse("goes with file only", "part", self.part)
        return self


class ThicknessRaster(Spec):
    """A raster of the thickness of snow, normal to the ground [m]."""

    EXAMPLES: ClassVar = {"file": "thickness.tif"}

    file: FileName
    """.asc or .tif raster, relative to the scene file; cells without data or with 0 hold no snow"""


@SHAPES.add
class Layer(Shape):
    """Snow between two distances from the terrain, measured normal to it."""

    EXAMPLES: ClassVar = {"attribute": "release_depth"}

    kind: Literal["layer"]
    bottom: NonNegative = 0.0
    """distance of its lower face from the terrain [m]"""
    top: Annotated[Annotated[Positive, NUMBER] | Annotated[Literal["file"], TEXT] | Annotated[ThicknessRaster, TABLE],
                   by_type(NUMBER, TEXT, TABLE)] = "file"
    """distance of its upper face from the terrain [m]; "file": bottom plus an attribute of the region file; { file =
    ... }: bottom plus the values of a raster, method = "depth" only"""
    attribute: Annotated[str, Field(strict=True, min_length=1, max_length=100)] | None = None
    """attribute of the region file that holds the thickness [m]; `thickness`, or else `d0`, when missing"""
    region: Region | None = None
    """where, in plan; everywhere on the terrain when missing"""

    @model_validator(mode="after")
    def _has_thickness(self):
        if self.attribute is not None and self.top != "file":
            raise refuse('goes with top = "file" only', "attribute", self.attribute)
        if self.top == "file":
            if not isinstance(self.region, PlanFile) and "top" not in self.model_fields_set:
                raise refuse("is missing: distance of its upper face from the terrain [m]", "top")
            if not isinstance(self.region, PlanFile):
                raise refuse("needs region = { file = ... } with an attribute thickness", "top", self.top)
        elif isinstance(self.top, ThicknessRaster):
            require_dimension(3, "a raster of thickness")
        elif self.top <= self.bottom:
            raise refuse(f"must be above bottom = {self.bottom:g}", "top", self.top)
        return self

    @property
    def thickness(self) -> float:
        return self.top - self.bottom if isinstance(self.top, int | float) else math.inf


BodyShape = Annotated[Shape, SHAPES.member()]
ObstacleShape = Annotated[Solid, OBSTACLES.member()]
