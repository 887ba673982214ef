"""What a component declares."""

import functools
import importlib.util
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any, ClassVar

from snowmpm.registry import COMPONENTS, Registry, resolved


@dataclass(frozen=True)
class Component:
    """An optional piece of physics.

    package: that its adapters lie in, a module for each method, named after it; words: what it is called in tables of
    `check`; asked: scene -> (key, value) of each key that asks for it; keys: `scenes.spec.Spec`s with keys that it
    adds to tables of a scene, by their places ("solver", "solver.implicit"); order: among the components, those of
    lower number act first; owns: what only one component at a time may have; beside: names of what it does not go with
    (`setup.refusals.FEATURES`); refuse: scene -> raises InputError for what cannot be; cautions: module with rules of
    `check`; atlas: module with ATLAS, {group: entries}; fields: scene -> number of the velocity field of each body;
    motion: "module:name" of (scene, number of an obstacle, `solids.shape.SolidShape`) -> its motion, or None;
    obstacles: "module:name" of scene -> what it makes, `setup.model.Model.made[name]`, and the `solids.Obstacle`s of
    that; steps: "module:name" of simulation -> what computes its steps in its place, by `step(until)`; refuse_resume:
    scene -> raises InputError for a run that cannot be resumed; moves_on:
    whether something moves on when the snow has come to rest; in_python: whether its cost goes with the speed of Python
    rather than that of kernels.

    Of one that carries bodies in place of particles that fill them: carries: (scene, body) -> whether it does; law:
    (scene, material) -> the law in place of that of the scene, or None; seeds: "module:name" of (scene, index of a
    body, ground, index of its material) -> `particles.population.Population`, or None; saw: "module:name" of the
    `saw_test.weak_layer.WeakLayer` of a saw test whose weak layer it carries.
    """

    REGISTRIES: ClassVar[tuple[Registry, ...]] = (COMPONENTS,)

    name: str
    package: str
    words: str
    asked: Callable[[Any], Iterable[tuple[str, object]]]
    order: int
    owns: tuple[str, ...] = ()
    beside: tuple[str, ...] = ()
    refuse: Callable[[Any], None] | None = None
    cautions: str = ""
    atlas: str = ""
    keys: Mapping[str, Any] = field(default_factory=dict)
    fields: Callable[[Any], Any] | None = None
    motion: str = ""
    obstacles: str = ""
    steps: str = ""
    refuse_resume: Callable[[Any], None] | None = None
    moves_on: bool = False
    in_python: bool = False
    carries: Callable[[Any, Any], bool] = lambda scene, body: False
    law: Callable[[Any, str], Any] = lambda scene, material: None
    seeds: str = ""
    saw: str = ""

    @property
    def solid(self) -> bool:
        """Whether it adds obstacles, or moves them."""
        return bool(self.motion or self.obstacles)

    def supports(self, method: str) -> bool:
        """Whether it has an adapter for a method."""
        return _exists(f"{self.package}.{method}")

    def registered(self) -> set[type]:
        """Of one that is added later: give tables of a scene its keys; -> those that have changed."""
        from snowmpm import components
        from snowmpm.scenes import schema  # noqa: F401  has opened its tables

        return components.extend(self)

    def adapter(self, method: str) -> Callable[..., Any]:
        """Its adapter for a method: model -> `stepping.component.Adapter`."""
        return resolved(f"{self.package}.{method}:adapter")


@functools.cache
def _exists(module: str) -> bool:
    return importlib.util.find_spec(module) is not None
