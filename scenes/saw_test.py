"""A propagation saw test: an isolated column of snow whose weak layer is cut by a saw.

    [saw_test]                                          z (normal to the slope)
    slope_angle = 30.0                                  |   ____________________________________
    length = 6.0                                        |  |  slab.1                            |
    weak_layer = { material = "weak", thickness = 0.05 }|  |  slab.0                            |
    [[saw_test.slab]]                                   |  |____________________________________|
    material = "slab"                                   |   (saw ->)     weak_layer
    thickness = 0.5                                     |   _____________base___________________
                                                        +---0-----------------------------length--> x (along the slope)

The scene is built in the frame of the slope, so that the layers follow the grid at any angle: x along the slope in the
direction of the saw, z normal to it; gravity is tilted by the slope angle. Bodies, domain and the saw follow from this
table.
"""

from math import ceil, cos, radians, sin, tan
from typing import Annotated, ClassVar, Literal

from pydantic import Field, ValidationInfo, field_validator, model_validator

from snowmpm import components
from snowmpm.scenes.space import require_dimension
from snowmpm.scenes.spec import NonNegative, Number, Positive, Spec, refuse

MARGIN = 1.0
"""Free space around the column [m]."""

MADE = ("bodies", "domain", "terrain")
"""Tables of a scene that a saw test creates itself or does not allow."""


class SawLayer(Spec):
    """A layer of the column."""

    material: str
    """name of one of the scene's materials, or of a material card"""
    thickness: Positive
    """normal to the slope [m]"""


class WeakLayer(SawLayer):
    """The layer that collapses."""

    cells: Annotated[int, Field(strict=True, ge=1, le=64)] | None = None
    """represent the layer by this many grid cells, whatever its thickness, with the same stiffness, strength and
    collapse per area (`Law.thickened_to`); its true thickness when missing"""


OWN_KEYS = frozenset(WeakLayer.model_fields)
components.open_table("saw_test.weak_layer", WeakLayer)


class SawTest(Spec):
    """Propagation saw test, in the frame of the slope: x along it in the direction of the saw, z normal to it."""

    EXAMPLES: ClassVar = {"resolution": 0.02}

    length: Positive
    """of the column along the slope [m]"""
    width: Positive | None = None
    """of the column across the slope, 3-D only; 0.3 when missing [m]"""
    slope_angle: Annotated[Number, Field(gt=-90.0, lt=90.0)] = 0.0
    """positive: the saw cuts upslope, negative: downslope [degrees]"""
    ends: Literal["normal", "vertical"] = "normal"
    """end faces of the column: normal to the slope, or vertical"""
    slab: Annotated[tuple[SawLayer, ...], Field(min_length=1)]
    """one table a layer, from the weak layer up"""
    weak_layer: WeakLayer
    base: SawLayer | None = None
    """snow between the weak layer and the rigid ground; none when missing"""
    notch: NonNegative = 0.0
    """length already cut at the start [m]"""
    saw_speed: Positive = 2.0
    """speed of the saw [m/s]"""
    saw_start: NonNegative = 0.0
    """when the saw begins to move [s]"""
    saw_length: NonNegative | None = None
    """total length of the cut, `notch` included; half of the column when missing [m]"""

    resolution: Positive | None = None
    """to which the critical length is wanted: width of the bins of the record; two cells when missing [m]"""

    @field_validator("width")
    @classmethod
    def _has_width_in_3d(cls, width):
        if width is not None:
            require_dimension(3, "width")
        return width

    @field_validator("notch", "saw_length")
    @classmethod
    def _within_the_column(cls, cut: float | None, info: ValidationInfo) -> float | None:
        length = info.data.get("length")
        if cut is not None and length is not None and cut >= length:
            raise refuse(f"must be less than length = {length:g}")
        return cut

    @model_validator(mode="after")
    def _saw_begins_at_the_notch(self):
        if self.saw_length is not None and self.saw_length < self.notch:
            raise refuse(f"must be at least notch = {self.notch:g}", "saw_length", self.saw_length)
        return self

    @model_validator(mode="after")
    def _weak_layer_has_its_own_material(self):
        others = [layer.material for layer in (*self.slab, *([self.base] if self.base else []))]
        cells = self.weak_layer.cells
        if cells is not None and self.weak_layer.material in others:
            raise refuse("needs a material that no other layer has", "weak_layer.cells", cells)
        return self

    @model_validator(mode="after")
    def _bins_lie_in_the_column(self):
        if self.resolution is not None and self.resolution > self.length:
            raise refuse(f"must be at most length = {self.length:g}", "resolution", self.resolution)
        return self

    def drawn(self, dx: float) -> "SawTest":
        """The test as represented on a grid: the weak layer has the thickness of its cells."""
        if self.weak_layer.cells is None:
            return self
        layer = self.weak_layer.model_copy(update={"thickness": self.weak_layer.cells * dx})
        return self.model_copy(update={"weak_layer": layer})

    @property
    def cut_length(self) -> float:
        """Final length of the cut [m]."""
        return max(self.notch, 0.5 * self.length if self.saw_length is None else self.saw_length)

    def width_in(self, dim: int) -> float:
        """Width of the column [m]; 1 in 2-D, where all quantities are per metre of width."""
        return (self.width or 0.3) if dim == 3 else 1.0

    @property
    def layers(self) -> list[tuple[str, SawLayer]]:
        """(name of the body, `SawLayer`) from the ground up."""
        base = [("base", self.base)] if self.base else []
        names = ["slab"] if len(self.slab) == 1 else [f"slab_{i + 1}" for i in range(len(self.slab))]
        return [*base, ("weak_layer", self.weak_layer), *zip(names, self.slab, strict=True)]

    @property
    def weak_layer_bottom(self) -> float:
        """z of the lower face of the weak layer [m]."""
        return self.base.thickness if self.base else 0.0

    @property
    def slab_bottom(self) -> float:
        """z of the upper face of the weak layer [m]."""
        return self.weak_layer_bottom + self.weak_layer.thickness

    @property
    def slab_thickness(self) -> float:
        """D [m]"""
        return sum(layer.thickness for layer in self.slab)

    @property
    def lean(self) -> float:
        """dx/dz of the end faces."""
        return tan(radians(self.slope_angle)) if self.ends == "vertical" else 0.0

    def gravity_vector(self, gravity: float, dim: int) -> tuple[float, ...]:
        """Components [m/s2] in the frame of the slope of `gravity` downward."""
        angle = radians(self.slope_angle)
        return (-gravity * sin(angle), *(0.0,) * (dim - 2), -gravity * cos(angle))


def _keys_of_components(layer):
    """Keys of the weak layer that components have added, and that are given: of the body that is made of it, too."""
    added = WeakLayer.model_fields.keys() - OWN_KEYS
    return {key: value for key in sorted(added) if (value := layer[key]) is not None}


def made_by(saw_test, dim, dx):
    """Tables of a scene that its saw test creates, as in a scene file."""
    saw_test = saw_test.drawn(dx)
    tall = saw_test.slab_bottom + saw_test.slab_thickness
    reach = MARGIN + abs(saw_test.lean) * tall

    def cells(length):
        return ceil(length / dx) * dx  # so that x = 0 and z = 0 lie on nodes of the grid

    across = [] if dim == 2 else [cells(0.5 * saw_test.width_in(dim) + 0.5 * MARGIN)]
    domain = {"min": [-cells(reach), *(-y for y in across), 0.0],
              "max": [cells(saw_test.length + reach), *across, cells(tall + 0.5 * MARGIN)],
              "boundary": {"z_min": "stick"}}
    bodies, bottom = [], 0.0
    for name, layer in saw_test.layers:
        carried = _keys_of_components(layer) if name == "weak_layer" else {}
        first = saw_test.notch if name == "weak_layer" and not carried else 0.0  # who carries a layer cuts it
        shape = _layer_shape(saw_test, dim, first, bottom, bottom + layer.thickness)
        bodies.append({"name": name, "material": layer.material, "shape": shape, **carried})
        bottom += layer.thickness
    return {"bodies": bodies, "domain": domain}


def _layer_shape(saw_test, dim, first, bottom, top):
    """Box, or leaning box, from x = `first` to the end of the column; the faces cross z = slab_bottom there."""
    half, last = 0.5 * saw_test.width_in(dim), saw_test.length
    if saw_test.lean == 0.0:
        across = ([-half], [half]) if dim == 3 else ([], [])
        return {"kind": "box", "min": [first, *across[0], bottom], "max": [last, *across[1], top]}

    def corner(x, z):
        return [x + saw_test.lean * (z - saw_test.slab_bottom), z]

    points = [corner(first, bottom), corner(last, bottom), corner(last, top), corner(first, top)]
    return {"points": points, **({"kind": "polygon"} if dim == 2 else {"kind": "prism", "y": [-half, half]})}
