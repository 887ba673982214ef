"""Shapes that bodies fill and obstacles have."""

from typing import Annotated, Literal

from pydantic import Field, model_validator

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


class Box(Spec):
    """A block along the axes; a rectangle in 2-D."""

    kind: Literal["box"]
    min: Vector
    """lower corner [m]"""
    max: Vector
    """upper corner [m]"""

    @model_validator(mode="after")
    def _corners(self):
        check_corners(self.min, self.max)
        return self


class Sphere(Spec):
    """A ball, a disc in 2-D."""

    kind: Literal["sphere"]
    centre: Vector
    """[m]"""
    radius: Positive
    """[m]"""


class Cylinder(Spec):
    """A solid cylinder (3-D)."""

    kind: Literal["cylinder"]
    base: Vector
    """centre of the base [m]"""
    axis: Direction
    """direction from the base to the top, of any length"""
    radius: Positive
    """[m]"""
    height: Positive
    """[m]"""

    @model_validator(mode="after")
    def _is_3d(self):
        require_dimension(3, 'shape of kind "cylinder"')
        return self


class SolidMesh(Spec):
    """The inside of a watertight triangle mesh (3-D)."""

    kind: Literal["mesh"]
    file: FileName
    """STL, OBJ or PLY file, relative to the scene file"""

    @model_validator(mode="after")
    def _is_3d(self):
        require_dimension(3, 'shape of kind "mesh"')
        return self


class Polygon(Spec):
    """The inside of a polygon in the plane of a 2-D scene."""

    kind: Literal["polygon"]
    points: Annotated[tuple[Vector, ...], Field(min_length=3)]
    """corners [x, z] [m]"""

    @model_validator(mode="after")
    def _is_2d(self):
        require_dimension(2, 'shape of kind "polygon"')
        return self


class Prism(Spec):
    """A polygon in the plane of x and z, extruded along y (3-D)."""

    kind: Literal["prism"]
    points: Annotated[tuple[Pair, ...], Field(min_length=3)]
    """corners [x, z] [m]"""
    y: Interval
    """[lower, upper] [m]"""

    @model_validator(mode="after")
    def _is_3d(self):
        require_dimension(3, 'shape of kind "prism"')
        return self


class Voxels(Spec):
    """The voxels of one value in an image, such as the ice of a microstructure."""

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


class ThicknessRaster(Spec):
    """A raster of the thickness of snow, normal to the ground [m]."""

    file: FileName
    """.asc or .tif raster, relative to the scene file; cells without data or with 0 hold no snow"""


class Layer(Spec):
    """Snow between two distances from the terrain, measured normal to it."""

    kind: Literal["layer"]
    bottom: NonNegative = 0.0
    """distance of its lower face from the terrain [m]"""
    top: Annotated[Annotated[Positive, NUMBER] | Annotated[Literal["file"], TEXT] | Annotated[ThicknessRaster, TABLE],
                   by_type(NUMBER, TEXT, TABLE)] = "file"
    """distance of its upper face from the terrain [m]; "file": bottom plus `thickness` in the region file; { file =
    ... }: bottom plus the values of a raster, method = "depth" only"""
    region: Region | None = None
    """where, in plan; everywhere on the terrain when missing"""

    @model_validator(mode="after")
    def _has_thickness(self):
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


BodyShape = Annotated[Box | Sphere | Cylinder | SolidMesh | Polygon | Prism | Layer | Voxels,
                      Field(discriminator="kind")]
ObstacleShape = Annotated[Box | Sphere | Cylinder | SolidMesh | Polygon, Field(discriminator="kind")]
