"""Rasters of elevations or other numbers, from ESRI ASCII grids and GeoTIFF; triangles between cells of elevations."""

import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from snowmpm.errors import InputError
from snowmpm.terrain import geotiff, map_units, undeclared
from snowmpm.terrain.ascii_grid import read_grid
from snowmpm.terrain.reference_system import system_beside


@dataclass(frozen=True, eq=False)
class Raster:
    """Heights z (ny, nx) [m], or other numbers, at cell centres x (nx,), y (ny,) [m], both ascending; NaN where there
    is no data.

    system: `ReferenceSystem` of x and y, in metres; None where the file names none.
    """

    x: np.ndarray
    y: np.ndarray
    z: np.ndarray
    system: Any = None

    def lattice(self):
        """A corner of the cells (2,), and their side [m]; None where they are not square."""
        steps = [np.ptp(axis) / (len(axis) - 1) for axis in (self.x, self.y) if len(axis) > 1]
        if not steps or np.ptp(steps) > 1e-6 * steps[0]:
            return None
        # In a text file, centre distances carry round-off, and the cell size has few digits
        cell = float(f"{steps[0]:.9g}")
        return np.array([self.x[0], self.y[0]]) - 0.5 * cell, cell


ELEVATIONS = "elevations"


def read_raster(path, box=None, key="terrain.file", elevation_unit=None, quantity=ELEVATIONS):
    """Raster of an .asc or .tif file, cut to the cells that span the plan box ((x0, y0), (x1, y1)) [m].

    A .tif names its reference system itself, the .prj file beside an .asc does. Feet are converted to metres, plan and
    heights each by its own unit; elevation_unit: that of heights, "m", "ft" or "us-ft", instead of what the file says.
    A rotated or sheared raster is resampled. Cells with a number that stands for "none" have no value, declared or not
    (`undeclared`). A warning names each conversion. Without a system, coordinates are taken as metres. quantity: plural
    of what the values are; those that are no elevations are converted where the band names a length.
    InputError: unknown kind of file, unreadable, degrees or another map that is not in lengths on the ground, no data
    at all, or none inside the box.
    """
    where = f"{key} = {str(path)!r}"
    elevated = quantity == ELEVATIONS
    if not elevated:
        elevation_unit = "m"  # as it is
    if _is_text(path, key, quantity):
        raster, told = _ascii(path, box, key, where, elevation_unit, quantity)
    else:
        raster, told = _geotiff(path, box, key, where, elevation_unit, quantity)
    if not np.isfinite(raster.z).any():
        cut = "in the part that the scene uses" if box is not None else "(only no-data cells)"
        raise InputError.at(key, str(path), f"has no {'elevation' if elevated else quantity} {cut}")
    if raster.system is None and elevated:
        map_units.refuse_unnamed_degrees(raster, where)
    if told:
        warnings.warn(f"{where}: {'; '.join(told)}", stacklevel=2)
    return raster


def _is_text(path, key, quantity):
    """Whether a file is an .asc; InputError if it is no .tif either."""
    suffix = Path(path).suffix.lower()
    if suffix not in (".asc", ".tif", ".tiff"):
        raise InputError.at(key, str(path), f"must be an .asc or .tif raster of {quantity}")
    return suffix == ".asc"


def system_of(path, key="terrain.file", quantity=ELEVATIONS):
    """`ReferenceSystem`, in metres, of the raster in a .tif or .asc file; None where it names none. InputError."""
    if _is_text(path, key, quantity):
        system = system_beside(path)
    else:
        with geotiff.opened(path, key) as source:
            system = geotiff.system_of(source, f"{key} = {str(path)!r}")
    return system and system.in_metres


def _ascii(path, box, key, where, elevation_unit, quantity):
    system = system_beside(path)
    frame = _Frame(system, box, where)
    x, y, z = read_grid(path, key, frame.window)
    return frame.in_metres(x, y, z, map_units.height_metres(elevation_unit, None, system, where), quantity)


def _geotiff(path, box, key, where, elevation_unit, quantity):
    with geotiff.opened(path, key) as source:
        system = geotiff.system_of(source, where)
        frame = _Frame(system, box, where)
        x, y, z = geotiff.read_band(source, where, frame.window)
        unit = source.units[0]
        height = map_units.height_metres(elevation_unit, unit, system, where) if quantity == ELEVATIONS else \
            map_units.length_metres(unit)
        raster, told = frame.in_metres(x, y, z, height, quantity)
        if aside := geotiff.beside_it(path, source):
            told.append(aside)
        if source.transform.b or source.transform.d:
            told.append(f"its rows do not run east: {quantity} are interpolated on a raster that does")
        if source.count > 1:
            told.append(f"the first of its {source.count} bands is taken as {quantity}")
        if len(source.subdatasets) > 1:
            told.append(f"the first of its {len(source.subdatasets)} pages is taken")
        if system is None:
            told.append("it names no coordinate system: x and y are taken as metres")
    return raster, told


class _Frame:
    """Georeference of a raster: its system, the requested plan box [m], and metres in a unit of x and y."""

    def __init__(self, system, box, where):
        self.system, self.box, self.where, self.metre, self.doubt = system, box, where, None, ""

    def window(self, x, y):
        """Slices of the centres x, y of a file that span the box, after checking that they are lengths."""
        self.metre = map_units.plan_metres(self.system, x[[0, -1]], y[[0, -1]], self.where)
        self.doubt = map_units.doubted(self.system, x[len(x) // 2], y[len(y) // 2])
        return tuple(_window(centres * self.metre, self.box, axis) for axis, centres in enumerate((x, y)))

    def in_metres(self, x, y, z, height, quantity):
        """`Raster` of what was read, without cells that only seem to hold a value, and warnings for the user."""
        system = self.system and self.system.in_metres
        z, told = _heights(x, y, z, self.metre, height) if quantity == ELEVATIONS else _without_marks(z)
        said = map_units.converted(self.metre, height, quantity)
        return Raster(x * self.metre, y * self.metre, z * height, system), [*told, *filter(None, (said, self.doubt))]


def _heights(x, y, z, metre, height):
    """Heights without cells that stand for "none", and warnings. metre, height: metres in a unit of x, and of z."""
    steps = [np.ptp(axis) / (len(axis) - 1) for axis in (x, y) if len(axis) > 1]
    found = undeclared.undeclared_heights(z, max(steps) * metre, height) if steps else None
    if found is None:
        return z, []
    side = "below" if found.off < 0.0 else "above"
    off = f", {abs(found.off):.0f} m {side} the others" if abs(found.off) < undeclared.HUGE else ""
    return np.where(found.where, np.nan, z), [
        f"{np.count_nonzero(found.where)} cells hold {found.value:.6g}{off}: taken as no data, which the file"
        " does not declare"]


def _without_marks(z):
    """The same for numbers that are no heights."""
    found = undeclared.marked(z)
    if not found.any():
        return z, []
    values, counts = np.unique(z[found], return_counts=True)
    return np.where(found, np.nan, z), [
        f"{np.count_nonzero(found)} cells hold {values[counts.argmax()]:.6g}: taken as no data, which the file does not"
        " declare"]


def _window(centres, box, axis):
    """Slice of the ascending cell centres along one axis, from the last before the box to the first after it."""
    if box is None:
        return slice(0, len(centres))
    first = np.searchsorted(centres, box[0][axis], side="right") - 1
    last = np.searchsorted(centres, box[1][axis], side="left") + 1
    first, last = np.clip([first, last], 0, len(centres))
    return slice(int(first), int(last))


def _centre_heights(z):
    """Heights (ny - 1, nx - 1) between four cells by cubic interpolation from sixteen; NaN where one is missing."""
    weights = np.array([-1.0, 9.0, 9.0, -1.0]) / 16.0
    ny, nx = z.shape
    centre = np.full((ny - 1, nx - 1), np.nan)
    if min(ny, nx) > 3:
        centre[1:-1, 1:-1] = sum(
            weights[i] * weights[j] * z[i : ny - 3 + i, j : nx - 3 + j] for i in range(4) for j in range(4)
        )
    return centre


def raster_facets(raster):
    """Vertices (n, 3) at the cell centres with data, two triangles between four of them, one where three have data; a
    centre of no triangle is left out.

    A square is split along the diagonal that is closer to the smooth surface through the surrounding cells, so that
    ridges and gullies are not cut; if that is unknown, along alternating diagonals.
    """
    ny, nx = raster.z.shape
    known = np.isfinite(raster.z)
    number = np.cumsum(known.T.ravel()).reshape(nx, ny).T - 1  # in the order of `topology.tidied`: by x, then y
    column, row = np.nonzero(known.T)
    vertices = np.column_stack([raster.x[column], raster.y[row], raster.z[row, column]])

    def corners(a):
        return a[:-1, :-1].ravel(), a[:-1, 1:].ravel(), a[1:, 1:].ravel(), a[1:, :-1].ravel()

    k, z, v = corners(known), corners(raster.z), corners(number)
    full = k[0] & k[1] & k[2] & k[3]
    smooth = _centre_heights(raster.z).ravel()
    chess = ((np.arange(ny - 1)[:, None] + np.arange(nx - 1)) % 2 == 0).ravel()
    nearer = np.abs(z[0] + z[2] - 2 * smooth) < np.abs(z[1] + z[3] - 2 * smooth)
    rising = full & np.where(np.isnan(smooth), chess, nearer)
    falling = full & ~rising
    three = (k[0].astype(np.int8) + k[1] + k[2] + k[3]) == 3
    groups = [(rising, (0, 1, 2)), (rising, (0, 2, 3)), (falling, (0, 1, 3)), (falling, (1, 2, 3))]
    groups += [(three & ~k[i], tuple(j for j in range(4) if j != i)) for i in range(4)]
    facets = np.concatenate([np.column_stack([v[i][where] for i in corner]) for where, corner in groups])
    used = np.zeros(len(vertices), bool)
    used[facets] = True
    return vertices[used], (np.cumsum(used) - 1)[facets]
