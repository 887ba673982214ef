"""Contact of bodies in a step of explicit MPM (`.pairs`), and what they gave each other, as numbers of the history."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from snowmpm.annotations import Floats
from snowmpm.components.body_contact.declare import body_friction, velocity_fields
from snowmpm.components.body_contact.pairs import CoulombPairs
from snowmpm.scenes.space import AXES
from snowmpm.stepping.component import Adapter


def adapter(model: Any) -> "BodyContact":
    """`BodyContact` of a `Model`."""
    return BodyContact(body_friction(model.scene), field_names(model.scene))


def field_names(scene: Any) -> list[str]:
    """Names of the velocity fields of a scene: of the body that has one for itself, and of those that share the first
    one, joined by "_and_"."""
    fields = velocity_fields(scene)
    return ["_and_".join(body.name for body, own in zip(scene.bodies, fields, strict=True) if own == field)
            for field in range(int(fields.max(initial=0)) + 1)]


class BodyContact(Adapter):
    """Bodies of an `MpmSolver` that push, rub and part where their nodes meet.

    friction (n, n): Coulomb mu between velocity fields; names (n,): of the fields, "" for one without a body.
    """

    name = "body_contact"

    def __init__(self, friction: Floats, names: list[str]) -> None:
        self._friction, self._names = friction, names

    def field_pairs(self, solver: Any, population: Any) -> CoulombPairs:
        """The pairs of its nodes."""
        return CoulombPairs.of(population, solver.particles.materials.density, self._friction, solver)

    def begin(self, solver: Any) -> None:
        """Take the solver."""
        self._solver, axes = solver, AXES[solver.dim]
        self._keys = [[f"{name}_reaction_{axis}" for axis in axes] if name else [] for name in self._names]
        self._unit = "N s/m" if solver.dim == 2 else "N s"

    def row(self) -> Mapping[str, float]:
        """Impulse that each body got from all others since time zero, by "NAME_reaction_x" and so on [N s]."""
        got = np.sum(self._solver.grid.fields.given, axis=1)
        return {key: float(value) for keys, values in zip(self._keys, got, strict=True)
                for key, value in zip(keys, values, strict=False)}

    def units(self) -> Mapping[str, str]:
        """Unit of each of these numbers."""
        return {key: self._unit for keys in self._keys for key in keys}
