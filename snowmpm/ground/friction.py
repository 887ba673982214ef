"""The friction of the ground of a scene: a law, and where the rasters of its numbers lie."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from snowmpm.errors import InputError
from snowmpm.reading.named_files import existing
from snowmpm.terrain.raster_values import raster_values

from .parametrised import STANDARD_GRAVITY, Parametrised
from .states import stresses


@dataclass(frozen=True)
class GroundFriction:
    """Law of friction, or of entrainment, of a scene's terrain. base_dir: folder that its files are relative to;
    system: `ReferenceSystem` of the terrain, or None; source: what messages begin with."""

    law: Parametrised
    base_dir: Path
    system: Any = None
    source: str | None = None

    @property
    def varies(self):
        """Whether numbers differ from place to place."""
        return bool(self.law.rasters)

    def on_nodes(self, x, y, *, on_terrain=None, gravity=STANDARD_GRAVITY):
        """`on_nodes` of its law in its system; InputError begins with the source."""
        try:
            return on_nodes(self.law, self.system, x, y, base_dir=self.base_dir, on_terrain=on_terrain,
                            gravity=gravity)
        except InputError as error:
            raise InputError(f"{self.source}: {error}" if self.source else str(error)) from None

    def numbers_at(self, plan, surface, gravity):
        """Numbers (n, parameters) at plan (n, dim - 1) [m] on a surface of the terrain. gravity [m/s2]: magnitude."""
        if self.varies:
            return self.on_nodes(*plan.T, on_terrain=np.isfinite(surface.height(plan)), gravity=gravity).T
        return np.tile(np.array(self.law.parameters(gravity), float), (len(plan), 1))

    def stress_at(self, plan, surface, gravity):
        """Of friction: function(rows (k,) of plan, states (k, 4)) -> `states.stresses` there."""
        numbers = self.numbers_at(plan, surface, gravity)
        return lambda rows, states: stresses(type(self.law), numbers[rows], states)


def on_nodes(law, system, x, y, *, base_dir=".", on_terrain=None, gravity=STANDARD_GRAVITY):
    """Numbers of a law at places x, y (nodes,) [m] -> (n_parameters, nodes), rows in the order of `law.PARAMETERS`.

    system: `ReferenceSystem` of x and y, None where the terrain names none. A raster in another system is read at the
    transformed places; where only one of both names a system, they are taken as the same. A place has the value of the
    cell in which it lies. on_terrain (nodes,) bool: places that the flow can reach, all when missing; the others take
    the value of the nearest cell with data.
    gravity [m/s2]: magnitude. InputError: no such raster, unreadable, in degrees, no value at a place on the terrain, a
    value out of range or that contradicts another.
    """
    x, y = np.asarray(x, float), np.asarray(y, float)
    used = np.ones(x.shape, bool) if on_terrain is None else np.asarray(on_terrain, bool)
    values, limits = {}, law.limits()
    for name, value in law.values.items():
        if name in law.rasters:
            key = f"{law.TABLE}.{name}.file"
            found = _sampled(existing(value.file, base_dir, key), key, name, system, (x, y), used)
            _check_range(found, limits[name], f"{key} = {value.file!r}", (x, y), used)
            value = np.clip(found, limits[name].least, limits[name].most)  # of places that nothing reaches
        values[name] = value
    if reason := law.contradiction({name: value if np.ndim(value) == 0 else value[used]
                                    for name, value in values.items()}):
        raise InputError(f"{law.TABLE}: {reason}")
    numbers = law.numbers(values, gravity)
    return np.stack([np.broadcast_to(np.asarray(number, float), x.shape) for number in numbers])


def _sampled(path, key, name, system, places, used):
    """Values of a raster at places; the nearest cell with data where a place that is not used has none."""
    found = raster_values(path, key, f"values of {name}", system, np.column_stack(places), used, filled=True)
    missing = ~found.there & used
    if missing.any():
        at = tuple(float(axis[missing][0]) for axis in places)
        raise InputError.at(key, str(path), f"has no value at {missing.sum()} of {used.sum()} places of the grid on the"
                            f" terrain, the first at x = {at[0]:.10g}, y = {at[1]:.10g}")
    return found.values


def _check_range(values, limits, where, places, used):
    wrong = limits.outside(values) & used
    if wrong.any():
        x, y = (float(axis[wrong][0]) for axis in places)
        raise InputError(f"{where}: holds {values[wrong][0]:.6g} at x = {x:.10g}, y = {y:.10g}"
                         f" ({wrong.sum()} of {used.sum()} places of the grid): must be {limits}")
