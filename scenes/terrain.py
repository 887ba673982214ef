"""The ground: plane, profile, triangle mesh or elevation raster, and its friction."""

from typing import Annotated, ClassVar, Literal

from pydantic import Field, model_validator

from snowmpm import components
from snowmpm.scenes.dams import Dam
from snowmpm.scenes.friction import Friction
from snowmpm.scenes.regions import PlanBox
from snowmpm.scenes.space import FileName, Pair, Vector, require_dimension, zero_vector
from snowmpm.scenes.spec import NonNegative, Number, Spec, refuse

Contact = Literal["separate", "slip", "stick"]


class Contacting(Spec):
    """How snow touches a solid: `stick` (no motion), `slip` (never leaves it) or `separate` (may leave it)."""

    contact: Contact = "separate"
    """separate: snow slides with friction and may lift off; slip: it never leaves the solid; stick: no motion"""


class Touching(Contacting):
    """A solid with Coulomb friction."""

    friction: NonNegative = 0.3
    """Coulomb coefficient of slip and separate [-]"""


class Ground(Contacting):
    """The ground, whose friction may follow another law."""

    friction: Friction = 0.3
    """Coulomb coefficient of slip and separate [-], or a table with a law of friction"""


class Plane(Ground):
    """A plane through `point`, dipping by `angle` towards +x, or towards `azimuth` in 3-D."""

    kind: Literal["plane"]
    point: Vector = Field(default_factory=zero_vector)
    """a point of the plane [m]"""
    angle: Annotated[Number, Field(gt=-90.0, lt=90.0)] = 0.0
    """dip below the horizontal [degrees]"""
    azimuth: Annotated[Number, Field(ge=-360.0, le=360.0)] = 0.0
    """direction of the dip, counter-clockwise from +x as seen from above [degrees]; 3-D only"""

    @model_validator(mode="after")
    def _azimuth_needs_3d(self):
        if self.azimuth != 0.0:
            require_dimension(3, "azimuth")
        return self


class Profile(Ground):
    """A line of straight pieces from left to right; in 3-D it is extruded along y."""

    kind: Literal["profile"]
    EXAMPLES: ClassVar = {"file": "profile.csv"}

    points: Annotated[tuple[Pair, ...], Field(min_length=2)] | None = None
    """corners [x, z], x growing [m]"""
    file: FileName | None = None
    """in place of points: table (.csv) with columns x and z [m]"""
    points_source: str | None = None
    """file of the points, in the scene of a run"""
    fillet: NonNegative = 0.0
    """radius that rounds every interior corner [m]; 0 keeps them sharp"""

    @model_validator(mode="after")
    def _runs_to_the_right(self):
        if self.points is None:
            raise refuse("is missing: corners [x, z] [m], or file", "points")
        for i, (before, after) in enumerate(zip(self.points, self.points[1:], strict=False)):
            if after[0] <= before[0]:
                raise refuse("x must grow from point to point", f"points.{i + 1}", after)
        return self


class Mesh(Ground):
    """A triangle mesh, open or watertight (3-D)."""

    kind: Literal["mesh"]
    file: FileName
    """STL, OBJ or PLY file, relative to the scene file"""

    @model_validator(mode="after")
    def _is_3d(self):
        require_dimension(3, 'terrain of kind "mesh"')
        return self


class Dem(Ground):
    """An elevation raster; cells of no-data are holes (3-D)."""

    EXAMPLES: ClassVar = {"attribution": "National survey, 2025"}

    kind: Literal["dem"]
    file: FileName
    """.asc or .tif raster, relative to the scene file"""
    region: PlanBox | None = None
    """part of the raster to use [m], in its own coordinates"""
    elevation_unit: Literal["m", "ft", "us-ft"] | None = None
    """unit of its elevations; when missing that of the file, or metres if the file names none"""
    attribution: str | None = None
    """credit of the data, printed on pictures and maps"""
    dams: tuple[Dam, ...] = ()
    """ridges that are raised on it"""

    @model_validator(mode="after")
    def _is_3d(self):
        require_dimension(3, 'terrain of kind "dem"')
        return self


components.open_table("terrain", Plane, Profile, Mesh, Dem)
Terrain = Annotated[Plane | Profile | Mesh | Dem, Field(discriminator="kind")]
