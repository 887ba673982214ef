"""Structures that another program computes, coupled by preCICE."""

from typing import Annotated, ClassVar

from pydantic import Field, model_validator

from snowmpm.components.structures.tables import MOST, kind
from snowmpm.scenes.space import FileName, Vector
from snowmpm.scenes.spec import Name, Positive, Spec, refuse
from snowmpm.scenes.terrain import Touching

Text = Annotated[str, Field(strict=True, min_length=1, max_length=200)]


class Precice(Spec):
    """Where the other program is met: names of a configuration of preCICE, version 3."""

    EXAMPLES: ClassVar = {"velocity": "Velocity"}

    file: FileName
    """the configuration (.xml)"""
    participant: Text = "Snow"
    """name of snowmpm in it"""
    mesh: Text = "Snow-Mesh"
    """that snowmpm provides: the nodes of this structure"""
    force: Text = "Force"
    """written: force of the snow on each node [N]; 2-D: [N/m]"""
    displacement: Text = "Displacement"
    """read: of each node from its place at the start [m]"""
    velocity: Text | None = None
    """read: of each node [m/s]; differences of the displacements when missing"""


@kind("external")
class External(Touching):
    """A polyline of nodes that another program moves: round in 3-D, in 2-D a plate. The snow meets its segments."""

    KEYS: ClassVar = ("precice", "points")
    MAKES: ClassVar = f"{__package__}.from_scene:polyline"
    OWN: ClassVar = False
    name: Name
    """unique among the structures"""
    points: Annotated[tuple[Vector, ...], Field(min_length=2, max_length=MOST + 1)]
    """corners of the polyline, where they are at the start [m]"""
    segments: Annotated[int, Field(strict=True, ge=1, le=MOST)] = 1
    """straight pieces of each stretch between two points"""
    width: Positive
    """outer diameter; 2-D: thickness of the plate [m]"""
    precice: Precice
    """the other program"""

    coupling: ClassVar[str] = "windows"
    """beside the ways of what snowmpm computes itself: the configuration has the scheme"""

    @model_validator(mode="after")
    def _has_stretches(self):
        for i, (a, b) in enumerate(zip(self.points, self.points[1:], strict=False)):
            if a == b:
                raise refuse("is where the point before it is", f"points.{i + 1}", list(b))
        if (total := self.segments * (len(self.points) - 1)) > MOST:
            raise refuse(f"must be fewer: {total} pieces in all, and {MOST} at most", "segments", self.segments)
        return self
