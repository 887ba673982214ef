"""The scene: everything a simulation needs, validated, in SI units with the last axis up."""

from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field, PrivateAttr, model_validator
from pydantic.functional_validators import ModelWrapValidatorHandler  # from 2.10 on also in pydantic itself

from snowmpm import components
from snowmpm.errors import did_you_mean
from snowmpm.glance import Glance
from snowmpm.materials import Material
from snowmpm.scenes.bodies import Body, Obstacle
from snowmpm.scenes.cards import cards_near, with_cards
from snowmpm.scenes.choices import Choice, choices, taking_over
from snowmpm.scenes.events import AnyEvent
from snowmpm.scenes.forces import AnyForce
from snowmpm.scenes.gravity import Gravity
from snowmpm.scenes.lines import with_lines_of_files
from snowmpm.scenes.numerics import Domain, Output, Solver
from snowmpm.scenes.picture import Picture
from snowmpm.scenes.reference import OF_SPACE, Reference
from snowmpm.scenes.saw_test import MADE, SawTest, made_by
from snowmpm.scenes.space import LIST, NUMBER, TABLE, Vector, by_type, surroundings
from snowmpm.scenes.spec import Name, NonNegative, Number, Positive, Spec, refuse
from snowmpm.scenes.stop import Stop
from snowmpm.scenes.switch import Switch, with_switches
from snowmpm.scenes.terrain import Terrain
from snowmpm.scenes.toml import to_toml
from snowmpm.scenes.water import AnyWater
from snowmpm.scenes.zone import Zone, with_zone


class Initial(Spec):
    """Stress at time zero: none, geostatic (in balance with the weight), settled by quasi-static relaxation, or an
    isotropic pressure held by walls; or the whole particle state, from another run."""

    EXAMPLES: ClassVar = {"lateral_pressure": 0.5, "from": "runs/settled"}

    stress: Literal["none", "geostatic", "settle", "isotropic"] = "none"
    """none; geostatic: in balance with the weight; settle: relaxed at rest; isotropic: a pressure"""
    lateral_pressure: NonNegative | None = None
    """stress along the layers over that across them, K0 [-]; the elastic value of each material when missing"""
    pressure: Positive | None = None
    """isotropic: the pressure in all material [Pa]"""
    tolerance: Positive = 2e-3
    """settle: limit of the largest speed over sqrt(g D), D the depth of the snow, and of the unbalanced share of the
    weight [-]"""
    relaxation: Literal["damped", "static"] = "damped"
    """settle: by damped steps in time, or by a static solver, where the method has one and the snow lies on ground and
    sides that hold it; elsewhere, and where it finds no balance, by damped steps all the same"""
    from_run: Annotated[str, Field(strict=True, min_length=1, max_length=1000)] | None = Field(
        default=None, alias="from"
    )
    """folder of a run, relative to the scene file: bodies of the same name start with the positions,
    velocities, stresses and state variables at its end; their shape here is ignored"""

    @model_validator(mode="after")
    def _has_stress(self):
        if self.stress in ("none", "isotropic") and self.lateral_pressure is not None:
            raise refuse('needs stress = "geostatic" or "settle"', "lateral_pressure", self.lateral_pressure)
        if (self.stress == "isotropic") != (self.pressure is not None):
            raise refuse('stress = "isotropic" and pressure belong together', "pressure", self.pressure)
        if self.from_run is not None and self.stress not in ("none", "settle"):
            raise refuse("does not go with from, which gives the stress: none or settle", "stress", self.stress)
        if self.from_run is not None and "\0" in self.from_run:
            raise refuse("must be the folder of a run", "from", self.from_run)
        return self


class Scene(Glance, Spec):
    """A scene file. Files it names are relative to `base_dir`, the folder of the TOML file."""

    name: Name
    """letters, digits, `_`, `-` and `.`; also the name of the default output folder"""
    dimension: Literal[2, 3]
    """2 (plane strain, axes x, z) or 3 (axes x, y, z)"""
    end_time: Positive
    """when the run ends [s]"""
    gravity: Annotated[
        Annotated[Number, NUMBER] | Annotated[Vector, LIST] | Annotated[Gravity, TABLE],
        by_type(NUMBER, LIST, TABLE),
    ] = 9.81
    """acceleration [m/s2], downward, or a vector, or a table that gives it over time"""
    seed: Annotated[int, Field(strict=True, ge=0, lt=2**32)] = 1
    """seed of every random choice"""
    output: Output = Output()
    solver: Solver
    """at least dx, the grid spacing"""
    domain: Domain | None = None
    terrain: Terrain | None = None
    """the ground: a plane, a profile, a mesh or an elevation raster; none when missing"""
    materials: dict[Name, Material] = Field(default_factory=dict)
    """one table a material, with numbers given here or taken from the material card `card`"""
    bodies: Annotated[tuple[Body, ...], Field(min_length=1)]
    """one table a body"""
    obstacles: tuple[Obstacle, ...] = ()
    events: tuple[AnyEvent, ...] = ()
    """what happens on the way, such as a saw cut, a skier or rain, one table each"""
    forces: Annotated[tuple[AnyForce, ...], Field(max_length=16)] = ()
    """accelerations and pressures in space and time"""
    water: AnyWater | None = None
    """water in the pores; none when missing"""
    initial: Initial = Initial()
    stop: Stop = Stop()
    """when a run ends before end_time"""
    switch: Annotated[tuple[Switch, ...], Field(max_length=4)] = ()
    """hand-over to another method while the scene runs, one table each, in their order"""
    zone: Zone | None = None
    """region in which a depth-averaged flow is computed in three dimensions"""
    saw_test: SawTest | None = None
    """a propagation saw test, which creates bodies and domain; x and z are then along the slope and normal to it"""
    reference: Reference | None = None
    """reference solution for `snowmpm compare`; the simulation ignores it"""
    picture: Picture = Picture()
    """of the gallery"""

    _base_dir: Path = PrivateAttr(default_factory=Path.cwd)
    _source: str | None = PrivateAttr(default=None)
    _choices: tuple[Choice, ...] = PrivateAttr(default=())
    _overrides: dict[str, Any] = PrivateAttr(default_factory=dict)

    @model_validator(mode="wrap")
    @classmethod
    def _announce_dimension(cls, data: Any, validate: ModelWrapValidatorHandler["Scene"]) -> "Scene":
        dimension = data.get("dimension") if isinstance(data, dict) else None
        known = type(dimension) is int and dimension in (2, 3)
        with surroundings(dimension=dimension if known else None):
            scene = validate(with_lines_of_files(with_zone(with_switches(with_cards(
                _with_saw_test(data, dimension) if known else data)))))
        return _with_choices(scene)

    @model_validator(mode="after")
    def _names_exist(self):
        _check_references(self)
        if self.reference is not None:
            _check_answer(self)
        return self

    @property
    def base_dir(self) -> Path:
        """Base folder of relative paths in the scene."""
        return self._base_dir

    @property
    def source(self) -> str:
        """Source of the scene for messages: the TOML file, or the scene's name if there is no file."""
        return self._source or self.name

    @property
    def overrides(self) -> dict[str, Any]:
        """Values by dotted key that replaced those of the scene's file when it was loaded (`--set`)."""
        return self._overrides

    @property
    def choices(self) -> tuple[Choice, ...]:
        """`Choice`s made for keys of the solver that the scene does not give (`snowmpm.scenes.choices`)."""
        return self._choices

    @property
    def gravity_vector(self) -> tuple[float, ...]:
        """Acceleration of gravity, one component per axis [m/s2]; for a table its `value`."""
        value = self.gravity.value if isinstance(self.gravity, Gravity) else self.gravity
        if isinstance(value, tuple):
            return value
        if self.saw_test:
            return self.saw_test.gravity_vector(value, self.dimension)
        return (0.0,) * (self.dimension - 1) + (-value,)

    def __str__(self):
        return repr(self)

    def _glance(self):
        facts = {"solver": f"{self.solver.method}, dx = {self.solver.dx:g} m, {self.solver.precision}",
                 "time": f"0 to {self.end_time:g} s, a frame every {self.output.interval:g} s",
                 "terrain": self.terrain.kind if self.terrain else "",
                 "materials": ", ".join(f"{name} ({law.kind})" for name, law in self.materials.items()),
                 "bodies": ", ".join(f"{body.name} ({body.shape.kind} of {body.material})" for body in self.bodies),
                 "obstacles": ", ".join(f"{one.name} ({one.shape.kind})" for one in self.obstacles),
                 "events": ", ".join(f"{event.kind} {event.get('body', '')}".strip() for event in self.events),
                 "saw test": f"{self.saw_test.slope_angle:g} degrees" if self.saw_test else "",
                 "switches": ", ".join(f"to {switch.to} when {switch.when}" for switch in self.switch),
                 "zone": f"{self.zone.solver.method}, dx = {self.zone.solver.dx:g} m" if self.zone else "",
                 "initial stress": self.initial.stress}
        return f"Scene {self.name} ({self.dimension}-D)", {name: text for name, text in facts.items() if text}

    def to_toml(self) -> str:
        """The resolved scene, every default written out and every file name absolute: loads to the same scene."""
        # As written before there were switches, zones and tables of components
        added = [key for key in type(self).model_fields if key not in OWN_KEYS]
        unused = [key for key in ("switch", "zone", *added) if not self[key]]
        return to_toml(self, leave_out=(*(MADE if self.saw_test else ()), *unused))


OWN_KEYS = frozenset(Scene.model_fields)
components.open_table("scene", Scene)


def _with_choices(scene):
    """Copy of the scene with the values that the program chooses for keys of the solver left open (`choices`), also of
    solvers that take over.

    Returns the scene itself if there is nothing to choose.
    """
    found, switches = choices(scene), list(scene.switch)
    if found:
        values = {key: value for choice in found for key, value in choice.values.items()}
        scene = scene.model_copy(update={"solver": scene.solver.model_copy(update=values)})
    for i, switch in enumerate(switches):
        for choice in taking_over(switch.solver):
            switches[i] = switch.model_copy(update={"solver": switch.solver.model_copy(update=choice.values)})
            found.append(choice)
    if found:
        scene = scene.model_copy(update={"switch": tuple(switches)})
        scene._choices = tuple(found)
    return scene


class _SawTestOnly(Spec):
    saw_test: SawTest


def _with_saw_test(data, dim):
    """Tables of a scene with those that its saw test creates; the given data is not changed."""
    if data.get("saw_test") is None:
        return data
    for key in MADE:
        if key in data:
            raise refuse("is made by saw_test: leave it out", key, data[key])
    if not isinstance(data.get("gravity", 0.0), int | float):
        raise refuse("must be a number [m/s2] beside saw_test, whose slope_angle gives the direction", "gravity",
                     data["gravity"])
    saw_test = _SawTestOnly.model_validate({"saw_test": data["saw_test"]}).saw_test
    solver = data.get("solver")
    dx = solver.get("dx") if isinstance(solver, dict) else None
    # An invalid spacing is refused when the scene is validated
    known = isinstance(dx, int | float) and dx > 0.0
    return {**data, **made_by(saw_test, dim, dx if known else 1.0)}


def _check_references(scene):
    """Check that referenced names exist, and that names of bodies and obstacles are unique."""
    for table in ("bodies", "obstacles"):
        seen = set()
        for i, item in enumerate(scene[table]):
            if item.name in seen:
                raise refuse(f"there is another of this name among the {table}", f"{table}.{i}.name", item.name)
            seen.add(item.name)
    for i, body in enumerate(scene.bodies):
        if body.material not in scene.materials:
            key = f"bodies.{i}.material" if not scene.saw_test else "saw_test"
            known = ", ".join(scene.materials) or "none"
            near = cards_near(body.material)
            card = f"; or a material card: did you mean {near}?" if near else ""
            hint = did_you_mean(body.material, scene.materials) or card
            raise refuse(f"must be one of the materials: {known}{hint}", key, body.material)
        if body.start_time > 0.0 and any(body.velocity):
            raise refuse("does not go with velocity: it lies still until then", f"bodies.{i}.start_time",
                         body.start_time)
        if body.start_time >= scene.end_time:
            raise refuse(f"must be below end_time = {scene.end_time:g}", f"bodies.{i}.start_time", body.start_time)
        if body.shape.kind == "layer" and scene.terrain is None:
            raise refuse("a layer lies on a terrain, and the scene has none", f"bodies.{i}.shape.kind", "layer")
        if scene.initial.stress == "settle" and any(body.velocity):
            raise refuse('does not go with initial.stress = "settle", which brings everything to rest',
                         f"bodies.{i}.velocity", body.velocity)
    for i, event in enumerate(scene.events):
        if event.OF and scene.get(event.OF) is None:
            raise refuse(f"needs {event.OF}: a table [{event.OF}]", f"events.{i}.kind", event.kind)
    bodies = [body.name for body in scene.bodies]
    _check_names_of_forces(scene)
    for table in ("events", "forces"):
        for i, item in enumerate(scene[table]):
            body = item.get("body")
            if body is not None and body not in bodies:
                near = did_you_mean(body, bodies)
                raise refuse(f"must be one of the bodies: {', '.join(bodies)}{near}", f"{table}.{i}.body", body)


def _check_names_of_forces(scene):
    """Check that forces with columns in the history have names of their own."""
    seen = set()
    for i, force in enumerate(scene.forces):
        name = force.get("name")
        if name in seen:
            raise refuse("there is another of this name among the forces", f"forces.{i}.name", name)
        seen.update([name] if name else [])


def _check_answer(scene):
    """Check that the kind of reference suits the dimension, and that its obstacles exist."""
    kind = scene.reference.kind
    wanted = 3 if kind in OF_SPACE else 2
    if scene.dimension != wanted:
        raise refuse(f"exists only in a {wanted}-D scene, and this one has dimension = {scene.dimension}",
                     "reference.kind", kind)
    obstacles = [obstacle.name for obstacle in scene.obstacles]
    for key in ("piston", "wall", "bed"):
        name = scene.reference.get(key)
        if name is not None and name not in obstacles:
            near = did_you_mean(name, obstacles)
            raise refuse(f"must be one of the obstacles: {', '.join(obstacles) or 'none'}{near}", f"reference.{key}",
                         name)
