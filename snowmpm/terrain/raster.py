"""Elevation rasters: ESRI ASCII grids by a parser of our own, GeoTIFF through rasterio; triangles between cells."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from snowmpm import memory
from snowmpm.errors import InputError

BYTES_PER_CELL = 60  # of the part of a raster that is read, while it is
HEADER = ("ncols", "nrows", "xllcorner", "xllcenter", "yllcorner", "yllcenter", "cellsize", "dx", "dy", "nodata_value")


@dataclass(frozen=True, eq=False)
class Raster:
    """Heights z (ny, nx) [m] at cell centres x (nx,), y (ny,) [m], both ascending; NaN where there is no data."""

    x: np.ndarray
    y: np.ndarray
    z: np.ndarray


def read_raster(path, box=None, key="terrain.file"):
    """Raster of an .asc or .tif file, cut to the cells that span the plan box ((x0, y0), (x1, y1)) [m].

    InputError: unknown kind of file, unreadable, no data at all, or none inside the box.
    """
    suffix = Path(path).suffix.lower()
    if suffix == ".asc":
        raster = read_ascii_grid(path, box, key)
    elif suffix in (".tif", ".tiff"):
        raster = read_geotiff(path, box, key)
    else:
        raise InputError.at(key, str(path), "must be an .asc or .tif elevation raster")
    if not np.isfinite(raster.z).any():
        where = "in the part that the scene uses" if box is not None else "(only no-data cells)"
        raise InputError.at(key, str(path), f"has no elevation {where}")
    return raster


def read_ascii_grid(path, box=None, key="terrain.file"):
    """ESRI ASCII grid: header of keyword-value lines, then rows from north to south; centre or corner registration."""
    try:
        lines = Path(path).read_text(encoding="ascii", errors="strict").splitlines()
    except OSError as error:
        raise InputError.at(key, str(path), f"cannot be read ({error.strerror})") from error
    except UnicodeDecodeError as error:
        raise InputError.at(key, str(path), "is not an ESRI ASCII grid (not plain text)") from error
    head, n = {}, 0
    for line in lines:
        words = line.split()
        if words and words[0].lower() not in HEADER:
            break
        if words:
            try:
                head[words[0].lower()] = float(words[1])
            except (IndexError, ValueError):
                raise InputError.at(key, str(path), f"line {n + 1}: {line.strip()!r} needs one number") from None
        n += 1
    try:
        nx, ny = int(head["ncols"]), int(head["nrows"])
        dx, dy = (head[k] if k in head else head["cellsize"] for k in ("dx", "dy"))
        x0, y0 = (
            head[f"{a}llcenter"] if f"{a}llcenter" in head else head[f"{a}llcorner"] + 0.5 * step
            for a, step in (("x", dx), ("y", dy))
        )
    except KeyError as error:
        missing = f"is not an ESRI ASCII grid: header line {error.args[0]!r} is missing"
        raise InputError.at(key, str(path), missing) from None
    if nx < 1 or ny < 1 or not (0 < dx < np.inf and 0 < dy < np.inf):
        raise InputError.at(key, str(path), "header must have positive ncols, nrows and cellsize")
    if nx * ny > Path(path).stat().st_size:
        raise InputError.at(key, str(path), f"is too short for the {nx} x {ny} values that its header promises")
    x, y = x0 + dx * np.arange(nx), y0 + dy * np.arange(ny)
    columns, rows = _window(x, box, 0), _window(y, box, 1)
    body = lines[n:]
    if len(body) == ny:  # one line a row, as the format says: only the rows of the window are parsed
        body = body[ny - rows.stop : ny - rows.start]
        kept = rows.stop - rows.start
    else:
        kept = ny
    try:
        z = np.array(" ".join(body).split(), dtype=float)
    except ValueError as error:
        raise InputError.at(key, str(path), f"holds something that is not a number ({error})") from None
    if z.size != kept * nx:
        raise InputError.at(key, str(path), f"holds {z.size} values where its header promises {kept * nx}")
    z = z.reshape(kept, nx)[::-1]
    z = z[:, columns] if kept < ny else z[rows, columns]
    return Raster(x[columns], y[rows], _without_no_data(z, head.get("nodata_value", -9999.0)))


def read_geotiff(path, box=None, key="terrain.file"):
    """First band of a GeoTIFF in a projected (metre) system, north up; only the window of the box is read."""
    try:
        import rasterio
        from rasterio.windows import Window
    except ImportError:
        raise InputError.at(key, str(path), "GeoTIFF needs the gis extra: pip install 'snowmpm[gis]'") from None
    if not Path(path).is_file():
        raise InputError.at(key, str(path), "cannot be read (no such file)")
    try:
        with rasterio.open(path) as source:
            t, nx, ny = source.transform, source.width, source.height
            if t.b or t.d or t.a <= 0 or t.e >= 0:
                raise InputError.at(key, str(path), "must be a raster with north up, not rotated")
            if source.crs is not None and source.crs.is_geographic:
                raise InputError.at(key, str(path), "is in degrees: project it to metres first")
            memory.require(8.0 * (nx + ny), f'{key} = "{path}"', "it is not a raster of elevations")
            x = t.c + t.a * (np.arange(nx) + 0.5)
            y = t.f + t.e * (np.arange(ny)[::-1] + 0.5)
            columns, rows = _window(x, box, 0), _window(y, box, 1)
            size = float(rows.stop - rows.start) * (columns.stop - columns.start)
            memory.require(BYTES_PER_CELL * size, f'{key} = "{path}"', "terrain.region or domain cut it")
            window = Window.from_slices((ny - rows.stop, ny - rows.start), (columns.start, columns.stop))
            z = source.read(1, window=window, masked=True).astype(float).filled(np.nan)[::-1]
            no_data = source.nodata
    except rasterio.errors.RasterioError as error:
        raise InputError.at(key, str(path), "is not a readable GeoTIFF") from error
    return Raster(x[columns], y[rows], _without_no_data(z, -9999.0 if no_data is None else no_data))


def _window(centres, box, axis):
    """Slice of the ascending cell centres along one axis, from the last before the box to the first after it."""
    if box is None:
        return slice(0, len(centres))
    first = np.searchsorted(centres, box[0][axis], side="right") - 1
    last = np.searchsorted(centres, box[1][axis], side="left") + 1
    first, last = np.clip([first, last], 0, len(centres))
    return slice(int(first), int(last))


def _without_no_data(z, no_data):
    return np.where((z == no_data) | ~np.isfinite(z), np.nan, z)


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
    """Vertices (n, 3) at the cell centres with data, two triangles between four of them, one where three have data.

    A square is split along the diagonal that comes nearer to the smooth surface through the cells around it, so that
    ridges and gullies are not cut; where that is not known, along alternating diagonals.
    """
    ny, nx = raster.z.shape
    known = np.isfinite(raster.z)
    number = np.cumsum(known.ravel()).reshape(ny, nx) - 1
    xx, yy = np.meshgrid(raster.x, raster.y)
    vertices = np.column_stack([xx[known], yy[known], raster.z[known]])

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
    facets = [np.column_stack([v[i][where] for i in corner]) for where, corner in groups]
    return vertices, np.concatenate(facets)
