"""The thickness of a layer from place to place, from a raster."""

import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from snowmpm.errors import InputError
from snowmpm.reading.named_files import existing
from snowmpm.seeding.attributes import THICKEST
from snowmpm.seeding.regions import Region
from snowmpm.terrain.raster import read_raster, system_of
from snowmpm.terrain.raster_values import raster_values

QUANTITY = "thicknesses of snow"

LEAST_LOST = 0.01
"""Share of the snow of a raster off the terrain that is told."""


@dataclass(frozen=True)
class RasterThickness:
    """Raster of the thickness of snow [m]. path: the file; key: of the scene; system: `ReferenceSystem` of the terrain,
    or None."""

    path: Path
    key: str
    system: Any = None

    @classmethod
    def of(cls, spec, base_dir, key, system):
        """spec: with `file`, relative to base_dir. InputError: no such file."""
        return cls(existing(spec.file, base_dir, key), key, system)

    def at(self, plan):
        """Thickness (n,) [m] at plan places (n, 2), 0 where the raster has none. InputError: one that is none."""
        return self._checked(raster_values(self.path, self.key, QUANTITY, self.system, plan).values, *plan.T)

    def _checked(self, values, x, y):
        """Values at x and y with 0 in place of none."""
        values = np.nan_to_num(values)
        wrong = (values < 0.0) | (values > THICKEST)
        if wrong.any():
            i = int(wrong.argmax())
            raise InputError.at(self.key, str(self.path), f"holds {values[i]:.6g} at x = {x[i]:.10g}, y = {y[i]:.10g},"
                                f" and {np.count_nonzero(wrong) - 1} more such values: a thickness must be from 0 to"
                                f" {THICKEST:g} m")
        return values

    def _tell_of_lost(self, surface, cells, thickness):
        """Warn of snow in cells (n, 2) off the terrain or where it has no data, which is left out."""
        off = np.isnan(surface.height(cells))
        share = float(thickness[off].sum() / thickness.sum())
        if share > LEAST_LOST:
            warnings.warn(f"{self.key} = {str(self.path)!r}: {share:.0%} of its snow lies off the terrain, or where the"
                          " terrain has no data, and is left out", stacklevel=2)

    def region(self, surface):
        """`Region` of the terrain, a rectangle around all cells with snow. InputError: there are none."""
        raster = read_raster(self.path, None, self.key, quantity=QUANTITY)
        places = np.meshgrid(raster.x, raster.y)
        z = self._checked(raster.z.ravel(), *(axis.ravel() for axis in places)).reshape(raster.z.shape)
        rows, columns = np.nonzero(z > 0.0)
        lower, upper = surface.lower[:2], surface.upper[:2]
        if len(rows):
            half = [0.5 * np.ptp(axis) / max(1, len(axis) - 1) for axis in (raster.x, raster.y)]
            ends = [(axis[at].min() - h, axis[at].max() + h)
                    for axis, at, h in zip((raster.x, raster.y), (columns, rows), half, strict=True)]
            corners = np.array([[x, y] for x in ends[0] for y in ends[1]])
            cells = np.column_stack([raster.x[columns], raster.y[rows]])
            named = system_of(self.path, self.key, QUANTITY)
            if named is not None and self.system is not None:
                corners, cells = (named.carried(places, self.system) for places in (corners, cells))
            self._tell_of_lost(surface, cells, z[rows, columns])
            lower, upper = np.maximum(lower, corners.min(axis=0)), np.minimum(upper, corners.max(axis=0))
        if not len(rows) or not (lower < upper).all():
            raise InputError.at(self.key, str(self.path), "has no cell with snow on the terrain")
        return Region(lower, upper, label=f"{self.key} = {self.path.name!r}", to_border=True)
