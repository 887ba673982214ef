"""Forest on the ground and snow that stops on it: tables, and what they do not go with.

    [[terrain.forest]]
    name = "larches"
    region = { file = "forest.geojson" }    # or polygon, or x and y
    drag = 0.01                             # or { file = "drag.tif" }
    detrainment = 5.0                       # Pa, or { file = "k.tif" }

    [terrain.deposition]
    law = "stopped"
    time = 1.0                              # s
"""

from collections.abc import Iterable
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal

from pydantic import Field, model_validator

from snowmpm.components.contract import Component
from snowmpm.ground import RasterValue
from snowmpm.ground.value import value
from snowmpm.registry import COMPONENTS
from snowmpm.scenes.regions import Region
from snowmpm.scenes.space import check_file, require_dimension
from snowmpm.scenes.spec import NonNegative, Spec, refuse

if TYPE_CHECKING:
    Drag = float | RasterValue
    Detrainment = float | RasterValue
else:
    Drag = value(0.0, 10.0)
    Detrainment = value(0.0, 1e5)


class Forest(Spec):
    """Trees that slow a flow down, and stop a part of it; method = "depth" only."""

    EXAMPLES: ClassVar = {"name": "protection forest"}

    name: Annotated[str, Field(min_length=1)]
    """in messages and tables"""
    region: Region | None = None
    """where, in plan; where its rasters have values when missing"""
    drag: Drag = 0.01
    """c of the shear stress c density v^2 that is added to the friction of the ground [-]"""
    detrainment: Detrainment = 0.0
    """K: mass K / v per area and time stops [Pa]"""

    @model_validator(mode="after")
    def _is_somewhere(self) -> Any:
        require_dimension(3, "forest")
        rasters = {name: number for name in ("drag", "detrainment")
                   if isinstance(number := self[name], RasterValue)}
        for name, raster in rasters.items():
            check_file(raster.file, f"{name}.file")
        if self.region is None and not rasters:
            raise refuse("is missing, and no raster says where the forest is", "region")
        return self


class Deposition(Spec):
    """Snow that has come to rest becomes ground; method = "depth" only."""

    law: Literal["stopped"] = "stopped"
    time: NonNegative = 1.0
    """in which a share of 1 - 1/e of the snow that rests does so [s]; 0: at once"""


class OfTerrain(Spec):
    """Keys of the ground."""

    forest: tuple[Forest, ...] = ()
    """trees in plan; method = "depth" only"""
    deposition: Deposition | None = None
    """what becomes of snow that stops; method = "depth" only"""


def asked(scene: Any) -> Iterable[tuple[str, object]]:
    """(key, value) of both."""
    if scene.terrain and scene.terrain.forest:
        yield "terrain.forest.0.name", scene.terrain.forest[0].name
    if scene.terrain and scene.terrain.deposition:
        yield "terrain.deposition.law", scene.terrain.deposition.law


COMPONENTS.add(Component("forest_and_deposition", __package__, "forest and deposition", asked, order=41,
                         keys={"terrain": OfTerrain}, beside=('water.scheme = "two_phase"',)))
