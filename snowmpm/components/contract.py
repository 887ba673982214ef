"""What a component declares."""

import functools
import importlib.util
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any, ClassVar

from snowmpm.registry import COMPONENTS, Registry, resolved


@dataclass(frozen=True)
class Component:
    """An optional piece of physics. What takes long to import is named, "module:name"."""

    REGISTRIES: ClassVar[tuple[Registry, ...]] = (COMPONENTS,)

    name: str
    package: str
    """that its adapters lie in, a module for each method, named after it; "" where `adapters` names them"""
    words: str
    """what it is called in tables of `check`"""
    asked: Callable[[Any], Iterable[tuple[str, object]]]
    """scene -> (key, value) of each key that asks for it"""
    order: int
    """among the components: those of lower number act first"""
    keys: Mapping[str, Any] = field(default_factory=dict)
    """`scenes.spec.Spec`s with keys that it adds to tables of a scene, by their places: "scene", "solver",
    "solver.implicit", "bodies", "obstacles", "terrain" or "saw_test.weak_layer" """

    adapters: Mapping[str, Any] = field(default_factory=dict)
    """by method, of one without a package: model -> `stepping.component.Adapter`, or "module:name" of it"""
    costs: Mapping[str, float] = field(default_factory=dict)
    """ns of each row of `Adapter.work` on one thread, of one that the table of the package does not know"""

    # ---- what it does not go with, and what is said of it -------------------------------------------------------

    owns: tuple[str, ...] = ()
    """what only one component at a time may have: "the deformation of particles", "the spare number of a node", "the
    velocity fields of nodes", "the contact of surfaces", "the weight of columns" """
    beside: tuple[str, ...] = ()
    """what it does not go with: tables of a scene, keys and values, 'water.scheme = "v_w"', or names of
    `setup.refusals.FEATURES`"""
    alone: bool = False
    """whether no other component goes with it"""
    double: str = ""
    """why it needs double precision, "beside ..."; empty where it does not"""
    refuse: Callable[[Any], None] | None = None
    """scene -> raises InputError for what cannot be"""
    refuse_resume: Callable[[Any], None] | None = None
    """scene -> raises InputError for a run that cannot be resumed"""
    told: Callable[[Any], Mapping[str, str]] = lambda scene: {}
    """scene -> facts that `check` prints, by name"""
    cautions: str = ""
    """module with rules of `check`"""
    atlas: str = ""
    """module with ATLAS, {group: entries}"""
    symptom: str = ""
    """of (choices of the solver, solver, dt [s]) of a run that failed -> (border of the atlas, value beyond it), or
    None"""
    in_python: bool = False
    """whether its cost goes with the speed of Python rather than that of kernels"""

    # ---- its part in a run, beside that of its adapters ---------------------------------------------------------

    builders: Mapping[str, str] = field(default_factory=dict)
    """by method: what builds the solver in place of `snowmpm.methods.MethodEntry.builder`"""
    events: tuple[str, ...] = ()
    """kinds of events that act on it"""
    fills: str = ""
    """of (scene, body, `particles.population.Population` of its particles) -> the same with what they start with in
    the columns of the component (`Population.columns`), or with particles of its own, of materials behind those of the
    scene"""
    laws: str = ""
    """of model -> the laws of these materials"""
    fields: Callable[[Any], Any] | None = None
    """scene -> number of the velocity field of each body"""
    lies: Callable[[Any, Any], bool] = lambda scene, body: False
    """(scene, body) -> whether the body is no part of the flow at the start"""
    motion: str = ""
    """of (scene, number of an obstacle, `solids.shape.SolidShape`) -> its motion, or None"""
    obstacles: str = ""
    """of scene -> what it makes, `setup.model.Model.made[name]`, and the `solids.Obstacle`s of that"""
    moves_on: bool = False
    """whether something moves on when the snow has come to rest"""
    rests: bool = False
    """whether nothing of it changes while the snow rests"""
    steps: str = ""
    """of simulation -> what computes its steps in its place, by `step(until)`"""
    accelerates: str = ""
    """of (solver, function) -> lets it act, for `Simulation.add_acceleration`"""

    # ---- of one that carries bodies in place of particles that fill them ----------------------------------------

    carries: Callable[[Any, Any], bool] = lambda scene, body: False
    """(scene, body) -> whether it does"""
    law: Callable[[Any, str], Any] = lambda scene, material: None
    """(scene, material) -> the law in place of that of the scene, or None"""
    seeds: str = ""
    """of (scene, index of a body, ground, index of its material) -> `particles.population.Population`, or None"""
    saw: str = ""
    """`saw_test.weak_layer.WeakLayer` of a saw test whose weak layer it carries"""

    @property
    def solid(self) -> bool:
        """Whether it adds obstacles, or moves them."""
        return bool(self.motion or self.obstacles)

    def supports(self, method: str) -> bool:
        """Whether it has an adapter for a method."""
        return method in self.adapters or (bool(self.package) and _exists(f"{self.package}.{method}"))

    def registered(self) -> set[type]:
        """Of one that is added later: give tables of a scene its keys; -> those that have changed."""
        from snowmpm import components
        from snowmpm.scenes import schema  # noqa: F401  has opened its tables

        return components.extend(self)

    def adapter(self, method: str) -> Callable[..., Any]:
        """Its adapter for a method: model -> `stepping.component.Adapter`."""
        return resolved(self.adapters.get(method) or f"{self.package}.{method}:adapter")


@functools.cache
def _exists(module: str) -> bool:
    return importlib.util.find_spec(module) is not None
