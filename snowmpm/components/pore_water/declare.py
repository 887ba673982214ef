"""Water that fills the pores of the snow, or a part of them, and flows through them: the table `[water]` with scheme =
"u_p", and what it does not go with.

    [water]
    permeability = 1e-9         # m2; or a table: law = "calonne", grain_size = 1e-3
    porosity = 0.6              # of all materials; from their density and that of ice when missing
    pressure = 1.0e4            # Pa, at the start
    surface = "drained"
    sides = { z_min = "drained" }
"""

from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field, field_validator, model_validator

from snowmpm.components.contract import Component
from snowmpm.errors import InputError
from snowmpm.registry import COMPONENTS, WATER
from snowmpm.scenes.space import AXES, check_file, dimension, require_dimension
from snowmpm.scenes.spec import Fraction, NonNegative, Number, Positive, Spec, refuse
from snowmpm.scenes.water import Border, KnownPermeability, WaterTable
from snowmpm.water.permeability import law_of
from snowmpm.water.refusals import DOUBLE, refuse_of_pores

SPLITS = {"semi_implicit": "mpm", "explicit": "mpm", "monolithic": "implicit", "fixed_stress": "implicit"}
"""The method of each split."""


class WaterSides(Spec):
    """Whether water leaves through the sides of the domain."""

    x_min: Border = "sealed"
    """side of small x"""
    x_max: Border = "sealed"
    """side of large x"""
    y_min: Border = "sealed"
    """side of small y, 3-D only"""
    y_max: Border = "sealed"
    """side of large y, 3-D only"""
    z_min: Border = "sealed"
    """lower side"""
    z_max: Border = "sealed"
    """upper side"""

    @model_validator(mode="after")
    def _fit_the_scene(self):
        for name in sorted(self.model_fields_set):
            # A scene that is written out whole names all sides
            if name[0] not in AXES.get(dimension(), "xyz") and self[name] != "sealed":
                raise refuse(f"a {dimension()}-D scene has no {name[0]}", name, self[name])
        return self


@WATER.add
class PoreWaterTable(WaterTable):
    """Water that fills the pores, or a part of them, and flows through them."""

    USUAL: ClassVar = True

    scheme: Literal["u_p"] = "u_p"
    """u_p: one velocity and a pore pressure; water moves through the skeleton by Darcy's law"""
    split: Literal["semi_implicit", "explicit", "monolithic", "fixed_stress"] = "semi_implicit"
    """semi_implicit: the step is that of the drained skeleton; explicit: it must follow waves in undrained snow, for
    comparison. method = "implicit" has monolithic: skeleton and water are solved for at once; fixed_stress: in turn,
    until both fit"""
    alpha: Positive = 1.0
    """fixed_stress: the skeleton's assumed answer to a change of pressure, over 1 / K_dr of equal compression along all
    axes of the scene [-]; below a half of the true one it does not settle"""
    tolerance: Annotated[Number, Field(ge=1e-12, le=1e-2)] = 1e-6
    """fixed_stress: water left without place over that of the first pass [-] at which a step is solved"""
    iterations: Annotated[int, Field(strict=True, ge=1, le=10_000)] = 100
    """fixed_stress: passes in a step at most; one that takes more is made in halves"""
    permeability: KnownPermeability
    """intrinsic permeability [m2]: a number, a raster { file = "..." }, or a table with law = "calonne" (snow) or
    "kozeny_carman" (grains) and grain_size [m]; times 5.5e6 it is the hydraulic conductivity at 0 °C [m/s]"""
    porosity: Annotated[Number, Field(gt=0.0, lt=1.0)] | None = None
    """share of the pores at the start [-]; 1 - density / 917 of each material when missing"""
    density: Positive = 1000.0
    """of water [kg/m3]"""
    bulk_modulus: Positive = 2.2e9
    """of water [Pa]"""
    viscosity: Positive = 1.792e-3
    """dynamic viscosity of water [Pa s]; at 0 °C when missing"""
    pressure: Number = 0.0
    """pore pressure at the start [Pa]"""
    table: Number | None = None
    """height z of the water table at the start [m]: below it the pressure is hydrostatic; replaces pressure"""
    saturation: Fraction = 1.0
    """share of the pores that water fills at the start, above the table if there is one [-]; below 1 needs suction"""
    suction: NonNegative | None = None
    """largest suction that pores hold before air enters [Pa], 0 for coarse snow; when missing, pores are always full"""
    surface: Border = "drained"
    """the free surface; drained: p = 0 there"""
    ground: Border = "sealed"
    """the terrain"""
    obstacles: Border = "sealed"
    """obstacles"""
    sides: WaterSides = WaterSides()
    """sides of the domain"""

    @field_validator("permeability")
    @classmethod
    def _raster_is_there(cls, value: Any) -> Any:
        if law_of(value) == "raster":
            require_dimension(3, "a raster of permeability")
            check_file(value.file, "file")
        return value

    @model_validator(mode="after")
    def _goes_together(self):
        if self.solved and self.suction is not None:
            raise refuse(f'does not go with split = "{self.split}", which needs pores that are always full', "suction",
                         self.suction)
        if self.saturation < 1.0 and self.suction is None:
            raise refuse("below 1 needs suction, the largest that pores hold before air enters", "saturation",
                         self.saturation)
        if self.table is not None and self.pressure != 0.0:
            raise refuse("does not go with table, which gives the pressure", "pressure", self.pressure)
        if self.suction is not None and self.pressure < -self.suction:
            raise refuse(f"must be >= -suction = {-self.suction:g}", "pressure", self.pressure)
        if self.saturation < 1.0 and self.table is None and self.pressure > 0.0:
            raise refuse("needs pores that are full: saturation = 1", "pressure", self.pressure)
        return self

    @property
    def solved(self) -> bool:
        """Whether the pressure is among the unknowns of the method's steps."""
        return self.split in ("monolithic", "fixed_stress")

    def drained(self, dimension: int) -> dict[str, bool]:
        """Whether each border lets water out, by name (`outlets`)."""
        sides = {f"{axis}_{end}": self.sides[f"{axis}_{end}"] for axis in AXES[dimension]
                 for end in ("min", "max")}
        kinds = {"surface": self.surface, "ground": self.ground, "obstacles": self.obstacles, **sides}
        return {name: kind == "drained" for name, kind in kinds.items()}


def asked(scene):
    """(key, value) of the table."""
    if scene.water is not None and scene.water.scheme == "u_p":
        able = scene.solver.method in SPLITS.values()
        yield ("water.split", scene.water.split) if able else ("water.scheme", "u_p")


def refuse_beside(scene):
    """Raise InputError for a split of another method, and what does not go with the water."""
    water, method = scene.water, scene.solver.method
    if method != SPLITS[water.split]:
        raise InputError.at("water.split", water.split, f'needs solver.method = "{SPLITS[water.split]}" in place of'
                            f' "{method}"', scene.source)
    refuse_of_pores(scene)
    if water.solved:
        _refuse_beside_solved(scene)


def _refuse_beside_solved(scene):
    """Raise InputError for events that the equations do not know, and surfaces that change how they hold the snow."""
    for i, event in enumerate(scene.events):
        if event.kind in ("rain", "melt"):
            raise InputError.at(f"events.{i}.kind", event.kind, 'needs solver.method = "mpm" in place of'
                                f' "{scene.solver.method}"', scene.source)
    terrain, sides = scene.terrain, scene.domain.sides(scene.dimension) if scene.domain else {}
    found = [(f"domain.boundary.{name}", side) for name, side in sides.items() if side in ("separate", "periodic")]
    found += [(f"obstacles.{i}.name", obstacle.name) for i, obstacle in enumerate(scene.obstacles)]
    if terrain and terrain.contact == "separate":
        found.append(("terrain.contact", terrain.contact))
    elif terrain and terrain.contact == "slip" and terrain.friction != 0.0:
        found.append(("terrain.friction", "a law" if not isinstance(terrain.friction, int | float)
                      else terrain.friction))
    if found:
        raise InputError.at(*found[0], f'does not go with water in solver.method = "{scene.solver.method}"',
                            scene.source)


COMPONENTS.add(Component(
    "pore_water", __package__, "water in the pores", asked, order=1, beside=("zone", "solver.kernel"),
    double=DOUBLE, refuse=refuse_beside,
    events=("rain", "melt", "drainage"), symptom=f"{__package__}.cautions:undrained",
    cautions=f"{__package__}.cautions", atlas=f"{__package__}.atlas"))
