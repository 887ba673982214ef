"""Cells of the maps of a run: whole multiples of the elevation raster's cells, and aligned with them.

Grid lines lie at phase + j cell, with j counted from the origin of the map coordinates. The grid therefore depends only
on the raster's cells and on the size of a map cell. Two runs on one terrain with equal map cells have the same grid,
whatever part of the terrain each of them reads.
"""

import math
from dataclasses import dataclass

import numpy as np

from snowmpm.errors import InputError

SLACK = 1e-6
"""Tolerance, as a share of a cell, for coordinates of a file that lie off a grid line by round-off."""

BYTES_PER_CELL = 330
"""Twelve maps, and their copies for the file and the checkpoint."""

NEAR = 0.01
"""Relative difference up to which a wish is taken as the nearest multiple: rasters of 5 m have cells of 4.99768 m."""


@dataclass(frozen=True, eq=False)
class MapGrid:
    """Square cells in plan: lower (2,) corner [m, scene coordinates], cell [m], shape (columns, rows along y)."""

    lower: np.ndarray
    cell: float
    shape: tuple

    @classmethod
    def over(cls, lower, upper, cell, phase=(0.0, 0.0)):
        """All cells of side `cell` [m] that touch the plan box from `lower` to `upper` (2,); phase: of the lines."""
        lower, upper, phase = (np.asarray(v, float)[:2] for v in (lower, upper, phase))
        first = np.floor((lower - phase) / cell + SLACK)
        last = np.maximum(np.ceil((upper - phase) / cell - SLACK), first + 1.0)
        return cls(phase + cell * first, float(cell), tuple((last - first).astype(int).tolist()))

    @property
    def memory(self):
        """Bytes that the maps of a run take on it, with their copies while they are written."""
        return BYTES_PER_CELL * float(self.shape[0]) * float(self.shape[1])

    @property
    def upper(self):
        """Upper corner (2,) [m]."""
        return self.lower + self.cell * np.array(self.shape)


def grid_for(lower, upper, least, wish=None, lattice=None):
    """The map grid of a run over its domain, `lower` to `upper` [m].

    least: smallest side [m] of a cell with enough particles; wish: side that the scene asks for (output.map_cell), or
    None; lattice: (phase (2,), cell) [m] of the elevation raster, or None.
    On a raster the side is the smallest multiple of the raster's cell that is at least `least`; without one, `least`
    rounded up to two digits. A wish may also be a whole fraction of the raster's cell. A wish within 1 % of one of
    them is taken as that one. InputError for another wish.
    """
    if lattice is None:
        return MapGrid.over(lower, upper, wish or rounded_up(least))
    corner, own = lattice
    # The phase of the whole raster, whichever corner a part of it begins at
    phase = own * (np.round(np.asarray(corner, float) / own, 6) % 1.0)
    if wish is None:
        return MapGrid.over(lower, upper, own * max(1, math.ceil(least / own - SLACK)), phase)
    ratio = wish / own if wish >= own else own / wish
    if abs(ratio - round(ratio)) > NEAR * ratio:
        below = own * math.floor(wish / own) if wish > own else own / math.ceil(own / wish)
        above = own * math.ceil(wish / own) if wish > own else own / math.floor(own / wish)
        raise InputError.at("output.map_cell", wish, f"must be a whole multiple of the raster's cells of {own:g} m, or"
                                                     f" a whole fraction of them: {below:g} or {above:g}")
    cell = own * round(ratio) if wish >= own else own / round(ratio)
    return MapGrid.over(lower, upper, cell, phase)


def rounded_up(length):
    """The length [m] rounded up to two digits: 8.2837 -> 8.3."""
    unit = 10.0 ** (math.floor(math.log10(length)) - 1)
    return round(math.ceil(length / unit - SLACK) * unit, 12)
