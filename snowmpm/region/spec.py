"""The file of a region: terrain, forest, scenarios of release, friction, samples, what is mapped, where it runs."""

from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field, model_validator

from snowmpm.campaigns.spec import Cluster, Count
from snowmpm.errors import InputError
from snowmpm.region.forest import COVER
from snowmpm.region.release_terrain import RULES, Rule
from snowmpm.region.thickness import Thickness
from snowmpm.scenes.file_spec import FileSpec
from snowmpm.scenes.friction_cards import friction_cards
from snowmpm.scenes.spec import Name, NonNegative, Number, Positive, Spec, refuse

File = Annotated[str, Field(strict=True, min_length=1)]
TERRAINS = ("open", "channelled", "gully", "flat")


class Forest(Spec):
    """What protects from releases and brakes the flow."""

    EXAMPLES: ClassVar = {"file": "forest.gpkg", "drag": 0.01}

    file: File
    """polygons (.gpkg, .geojson, .shp), or a raster of crown cover [%] (.tif), relative to the file of the region"""
    cover: Annotated[Number, Field(gt=0.0, le=100.0)] = COVER
    """crown cover from which trees keep slabs from releasing, in the unit of the raster: per cent as a rule"""
    protects: bool = True
    """whether nothing releases in it; false: as if it were cut down"""
    drag: Annotated[NonNegative, Field(le=1.0)] = 0.0
    """by which it brakes the flow [-], as `terrain.forest` has it; 0.01 in AvaFrame"""


class Bounds(Spec):
    """Changes of the rule of a scenario; what is missing is as published."""

    EXAMPLES: ClassVar = {"least": 30.0, "most": 50.0, "curvature": 5.5, "ruggedness": 0.035, "altitude": 600.0,
                          "mean": 30.0, "scale": 800.0, "smallest": 2500.0, "largest": 60_000.0}

    least: Annotated[Number, Field(ge=15.0, le=60.0)] | None = None
    """least slope [degrees]"""
    most: Annotated[Number, Field(ge=30.0, le=80.0)] | None = None
    """largest slope [degrees]"""
    curvature: Positive | None = None
    """largest plan curvature, either way [1/100 m]"""
    ruggedness: Positive | None = None
    """largest ruggedness [-]"""
    altitude: Number | None = None
    """least altitude [m]"""
    mean: Annotated[Number, Field(ge=15.0, le=60.0)] | None = None
    """least mean slope of an area [degrees]"""
    scale: Positive | None = None
    """how unlike the parts of an area may be [m2]"""
    smallest: Positive | None = None
    """plan area [m2]"""
    largest: Positive | None = None
    """plan area [m2]"""


class Scenario(Spec):
    """Releases of a return period."""

    EXAMPLES: ClassVar = {"file": "release_areas.gpkg", "areas": "rare", "bounds": {"least": 32.0}}

    period: Annotated[Number, Field(ge=1.0, le=10_000.0)]
    """return period [years]"""
    areas: Literal["frequent", "rare", "extreme"] | None = None
    """rule of release areas; by the return period when missing: up to 30 years, up to 100, beyond"""
    file: File | None = None
    """in place of it: polygons of release areas (.gpkg, .geojson, .shp), with an attribute thickness or the table"""
    bounds: Bounds = Bounds()
    thickness: Thickness | None = None
    """of the releases; must be given unless the file has it"""

    @model_validator(mode="after")
    def _fits(self):
        if self.file is None and self.thickness is None:
            raise refuse("is missing: value, file or three_day_snow", "thickness")
        if self.file is not None and (self.areas is not None or self.bounds != Bounds()):
            raise refuse("does not go with areas or bounds, which say how areas are found", "file", self.file)
        return self

    @property
    def rule(self):
        """`Rule` of its release areas."""
        name = self.areas or next((name for name, rule in RULES.items() if self.period <= rule.period), "extreme")
        changed = {key: value for key, value in self.bounds.model_dump().items() if value is not None}
        return Rule(**{**vars(RULES[name]), **changed, "period": self.period})


class FrictionClass(Spec):
    """Voellmy's numbers of a kind of ground, a band of altitude and of volume."""

    EXAMPLES: ClassVar = {"terrain": "channelled", "above": 1500.0, "mu": 0.25, "xi": 1500.0}

    terrain: Literal["open", "channelled", "gully", "flat"]
    """kind of ground, by its plan curvature and slope"""
    above: Number = -500.0
    """altitude from which it holds, up to that of the next class [m]"""
    volume: NonNegative = 0.0
    """of the release from which it holds, up to that of the next class [m3]"""
    mu: Annotated[Number, Field(gt=0.0, le=1.0)]
    """Coulomb's part [-]"""
    xi: Annotated[Number, Field(ge=100.0, le=20_000.0)]
    """turbulent part [m/s2]"""


class Friction(Spec):
    """Friction of the flow: a published card, or classes."""

    card: str | None = None
    """friction card (`snowmpm list`)"""
    classes: tuple[FrictionClass, ...] = ()
    """numbers by ground, altitude and volume, in place of a card"""

    @model_validator(mode="after")
    def _one(self):
        if bool(self.classes) == (self.card is not None):
            raise refuse("needs one of card and classes")
        if self.card is not None and self.card not in friction_cards():
            raise refuse(f"must be one of {', '.join(friction_cards())}", "card", self.card)
        missing = [kind for kind in TERRAINS if self.classes and not any(
            one.terrain == kind for one in self.classes)]
        if missing:
            raise refuse(f"has none for terrain {', '.join(missing)}", "classes", [len(self.classes)])
        places = [(one.terrain, one.volume, one.above) for one in self.classes]
        if len(set(places)) < len(places):
            raise refuse("two of them are for one terrain, altitude and volume", "classes", [len(places)])
        return self


class Samples(Spec):
    """What is not known: each release is run so often, with other numbers (Latin hypercube)."""

    EXAMPLES: ClassVar = {"runs": 5, "thickness": 0.2, "friction": 0.15}

    runs: Annotated[int, Field(strict=True, ge=1, le=1000)] = 1
    """of each release; 1: with the numbers as they are"""
    thickness: Annotated[Number, Field(ge=0.0, le=1.0)] = 0.2
    """deviation of the logarithm of the thickness [-]"""
    friction: Annotated[Number, Field(ge=0.0, le=1.0)] = 0.15
    """deviation of the logarithm of mu [-]"""
    seed: Annotated[int, Field(strict=True, ge=0, lt=2**32)] = 1
    """of the design"""


class Flow(Spec):
    """The flow of each release."""

    cell: Positive | None = None
    """side of its cells [m], a whole multiple of those of the terrain; when missing the smallest of 5 m or more"""
    end_time: Annotated[Number, Field(ge=20.0, le=3600.0)] = 600.0
    """at the latest [s]; it ends before, at rest"""
    density: Positive = 200.0
    """of the flow [kg/m3]"""
    reach: Annotated[Number, Field(ge=5.0, le=30.0)] = 15.0
    """travel angle [degrees] of the routing that gives the first window of terrain, and says which releases can reach
    the area of interest"""


class RegionFile(FileSpec):
    """A region. Paths are relative to its file."""

    EXAMPLES: ClassVar = {"attribution": "National survey, 2025", "area_of_interest": "villages.gpkg",
                          "exposed": ["houses.gpkg", "roads.gpkg"], "keep": "runs",
                          "zones": "switzerland"}

    name: Name
    """also the name of the default output folder"""
    terrain: File
    """elevation raster (.tif, .asc) in metres"""
    attribution: str | None = None
    """credit of the data, printed on the page"""
    forest: Forest | None = None
    area_of_interest: File | None = None
    """polygons (.gpkg, .geojson, .shp): releases that cannot reach them are not run"""
    exposed: tuple[File, ...] = ()
    """vector layers of buildings, roads and the like: a table says what reaches each of their features"""
    scenarios: Annotated[dict[Name, Scenario], Field(min_length=1, max_length=20)]
    """one table a scenario"""
    flow: Flow = Flow()
    friction: Friction
    samples: Samples = Samples()
    pressures: Annotated[tuple[Positive, ...], Field(min_length=1, max_length=6)] = (1e3, 3e3, 1e4, 3e4)
    """pressures that divide the classes [Pa], and whose frequency is mapped"""
    zones: Literal["switzerland", "norway"] | None = None
    """zones of hazard maps, by the definition of a country (`snowmpm docs region`)"""
    most_releases: Count | None = None
    """of each scenario: an even choice of so many, for a trial"""
    keep: Literal["runs", "results"] = "results"
    """what stays of a run: its folder, or only its numbers and maps"""
    cluster: Cluster = Cluster()

    @model_validator(mode="after")
    def _fits(self):
        if list(self.pressures) != sorted(set(self.pressures)):
            raise refuse("must increase", "pressures", list(self.pressures))
        return self

    def path(self, file: str) -> Path:
        """A file that it names."""
        return self._base_dir / file


def is_region(data: Any) -> bool:
    """Whether tables are those of a region rather than of a scene."""
    return isinstance(data, dict) and "scenarios" in data and isinstance(data.get("terrain"), str)


def read_region(path: Path) -> RegionFile:
    """`RegionFile` from a TOML file; InputError, which names file, key, value and what is allowed."""
    found = RegionFile.read(path, "region")
    for key, file in (("terrain", found.terrain), ("forest.file", found.forest and found.forest.file),
                      ("area_of_interest", found.area_of_interest),
                      *((f"exposed.{k}", one) for k, one in enumerate(found.exposed)),
                      *((f"scenarios.{name}.file", one.file) for name, one in found.scenarios.items()),
                      *((f"scenarios.{name}.thickness.file", one.thickness and one.thickness.file)
                        for name, one in found.scenarios.items())):
        if file and not found.path(file).is_file():
            raise InputError.at(key, file, "no such file", file=found.source)
    return found
