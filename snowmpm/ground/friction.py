"""The friction of the ground of a scene: a law, and where the rasters of its numbers lie."""

import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from snowmpm.errors import InputError
from snowmpm.terrain.load import existing
from snowmpm.terrain.raster import read_raster, system_of

from .parametrised import STANDARD_GRAVITY, Parametrised

EDGE = 1e-6
"""How far outside its outermost cells [cells] a place still belongs to a raster: round-off of coordinates."""


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
    named = system_of(path, key, f"values of {name}")
    points = np.column_stack(places)
    if system is not None and named is not None:
        points = system.carried(points, named)
        if not np.isfinite(points[used]).all():
            raise InputError.at(key, str(path), f"is in {named.name}, to where no way leads from {system.name}, the"
                                " terrain's")
        points = np.where(np.isfinite(points), points, 0.0)
    elif named is not None:
        told = f"{key} = {str(path)!r}: is in {named.name}, and the terrain names no coordinate system"
        warnings.warn(f"{told}: taken as the same", stacklevel=3)
    raster = _read(path, key, name, points[used] if used.any() else points)
    column, row, out = _cells(raster, points)
    missing = (out | np.isnan(raster.z[row, column])) & used
    if missing.any():
        at = tuple(float(axis[missing][0]) for axis in places)
        raise InputError.at(key, str(path), f"has no value at {missing.sum()} of {used.sum()} places of the grid on the"
                            f" terrain, the first at x = {at[0]:.10g}, y = {at[1]:.10g}")
    return _filled(raster.z)[row, column]


def _read(path, key, name, points):
    """The part of a raster around points, at least two cells wide: its cell size is the distance of centres."""
    for box in ((points.min(axis=0), points.max(axis=0)), None):
        raster = read_raster(path, box, key, quantity=f"values of {name}")
        if min(raster.z.shape) > 1:
            return raster
    raise InputError.at(key, str(path), "must have at least two rows and two columns")


def _cells(raster, points):
    """Column and row of the cell of each point, those of the nearest one outside, and whether it lies outside."""
    found, out = [], np.zeros(len(points), bool)
    for axis, centres in enumerate((raster.x, raster.y)):
        step = (centres[-1] - centres[0]) / (len(centres) - 1)
        at = (points[:, axis] - centres[0]) / step
        out |= (at < -0.5 - EDGE) | (at > len(centres) - 0.5 + EDGE)
        found.append(np.clip(np.floor(at + 0.5).astype(int), 0, len(centres) - 1))
    return (*found, out)


def _filled(z):
    """Values with each missing one replaced by that of the nearest cell that has one."""
    from scipy.ndimage import distance_transform_edt  # slow to import

    empty = np.isnan(z)
    if not empty.any():
        return z
    rows, columns = distance_transform_edt(empty, return_distances=False, return_indices=True)
    return z[rows, columns]


def _check_range(values, limits, where, places, used):
    wrong = limits.outside(values) & used
    if wrong.any():
        x, y = (float(axis[wrong][0]) for axis in places)
        raise InputError(f"{where}: holds {values[wrong][0]:.6g} at x = {x:.10g}, y = {y:.10g}"
                         f" ({wrong.sum()} of {used.sum()} places of the grid): must be {limits}")
