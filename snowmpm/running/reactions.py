"""What bodies of snow that slide on each other and part gave each other, as numbers of the history."""

from typing import Any

import numpy as np

from snowmpm.annotations import Floats
from snowmpm.scenes.space import AXES
from snowmpm.setup.velocity_fields import velocity_fields


class Reactions:
    """Names of the velocity fields of a scene: of the body that has one for itself, and of those that share the first
    one, joined by "_and_"."""

    def __init__(self, scene: Any) -> None:
        fields = velocity_fields(scene)
        self._names = ["_and_".join(body.name for body, own in zip(scene.bodies, fields, strict=True) if own == field)
                       for field in range(int(fields.max(initial=0)) + 1)]
        self._axes = AXES[scene.dimension]
        self._unit = "N s/m" if scene.dimension == 2 else "N s"

    def row(self, between: Floats | None) -> dict[str, float]:
        """Impulse that each body got from all others since time zero, by "NAME_reaction_x" and so on [N s]; nothing of
        a solver whose snow is one. between (n, n, dim): `stepping.contract.Method.between_bodies`."""
        if between is None:
            return {}
        return {key: float(value) for keys, values in zip(self._keys(), np.sum(between, axis=1), strict=True)
                for key, value in zip(keys, values, strict=True) if key[0] != "_"}

    def units(self) -> dict[str, str]:
        """Unit of each of these numbers."""
        return {key: self._unit for keys in self._keys() for key in keys if key[0] != "_"}

    def _keys(self) -> list[list[str]]:
        return [[f"{name}_reaction_{axis}" for axis in self._axes] for name in self._names]
