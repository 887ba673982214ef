"""Values of a raster at places in plan: each place has the value of the cell in which it lies."""

import warnings
from typing import NamedTuple

import numpy as np

from snowmpm.errors import InputError
from snowmpm.terrain.raster import read_raster, system_of

EDGE = 1e-6
"""How far outside its outermost cells [cells] a place still belongs to a raster: round-off of coordinates."""


class RasterValues(NamedTuple):
    """values (n,), NaN or those of the nearest cell where the raster has none; there (n,): where it has one."""

    values: np.ndarray
    there: np.ndarray


def raster_values(path, key, quantity, system, points, used=None, filled=False):
    """`RasterValues` of a .asc or .tif raster at plan places (n, 2) [m].

    quantity: what it holds, in messages; system: `ReferenceSystem` of the places, None where they have none. A raster
    in another one is read at the transformed places; where only one of both names a system, they are taken as the same.
    used (n,): places that matter, all when missing; filled: whether places without a value take that of the nearest
    cell that has one. InputError: unreadable, in degrees, fewer than two rows or columns, out of reach of the system.
    """
    used = np.ones(len(points), bool) if used is None else used
    named = system_of(path, key, quantity)
    if system is not None and named is not None:
        points = system.carried(points, named)
        if not np.isfinite(points[used]).all():
            raise InputError.at(key, str(path), f"is in {named.name}, to where no way leads from {system.name}, the"
                                " terrain's")
        points = np.where(np.isfinite(points), points, 0.0)
    elif named is not None:
        told = f"{key} = {str(path)!r}: is in {named.name}, and the terrain names no coordinate system"
        warnings.warn(f"{told}: taken as the same", stacklevel=4)
    raster = _read(path, key, quantity, points[used] if used.any() else points)
    column, row, out = _cells(raster, points)
    there = ~(out | np.isnan(raster.z[row, column]))
    values = (_filled(raster.z) if filled else raster.z)[row, column]
    return RasterValues(values if filled else np.where(there, values, np.nan), there)


def _read(path, key, quantity, points):
    """The part of a raster around points, at least two cells wide: its cell size is the distance of centres."""
    for box in ((points.min(axis=0), points.max(axis=0)), None):
        raster = read_raster(path, box, key, quantity=quantity)
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
