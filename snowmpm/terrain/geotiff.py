"""Elevations from GeoTIFF files, through rasterio: north up or rotated, only the requested part."""

import contextlib
import warnings
from pathlib import Path

import numpy as np

from snowmpm.errors import InputError
from snowmpm.reading import budget as read_budget
from snowmpm.terrain.reference_system import ReferenceSystem

USUAL_NO_DATA = -9999.0
"""What a raster that declares nothing holds where it has no value, by custom."""

MAGIC = (b"II*\0", b"MM\0*", b"II+\0", b"MM\0+")
"""First bytes of a TIFF and a BigTIFF file, in both orders of bytes."""

CELL_BYTES = 60
"""Memory per cell while it is read."""

ADVICE = "terrain.region or domain cut it"


@contextlib.contextmanager
def opened(path, key):
    """Dataset of a GeoTIFF file. GDAL must read it as no other format, whatever its content: formats such as VRT name
    further files and addresses that would be read. InputError: no rasterio, no TIFF."""
    try:
        import rasterio
    except ImportError:
        raise InputError.at(key, str(path), "GeoTIFF needs the gis extra: pip install 'snowmpm[gis]'") from None
    path = Path(path).absolute()
    for file in (path, path.with_name(f"{path.name}.msk")):  # a mask file beside it, which GDAL opens automatically
        _require_tiff(file, path, key)
    try:
        with rasterio.open(path, driver="GTiff", sharing=False) as source:
            yield source
    except (rasterio.errors.RasterioError, rasterio.errors.RasterioIOError) as error:  # two families before 1.4
        raise InputError.at(key, str(path), "is not a readable GeoTIFF") from error


def beside_it(path, source):
    """What the file .aux.xml beside a GeoTIFF, which GDAL obeys, has other than the GeoTIFF: a warning, or ""."""
    import rasterio

    side = Path(path).with_name(f"{Path(path).name}.aux.xml")
    if not side.is_file():
        return ""
    with (rasterio.Env(GDAL_PAM_ENABLED="NO"),
          rasterio.open(Path(path).absolute(), driver="GTiff", sharing=False) as own):
        pairs = {"place": (own.transform, source.transform), "coordinate system": (own.crs, source.crs),
                 "number for no data": (own.nodata, source.nodata),
                 "scale": (own.scales[:1] + own.offsets[:1], source.scales[:1] + source.offsets[:1])}
        different = [name for name, (one, other) in pairs.items()
                     if one != other and not (one is not None and one != one and other != other)]
    return f"{' and '.join(different)} come from {side.name}, and the file itself has others" if different else ""


def system_of(source, where):
    """`ReferenceSystem` of an open dataset, None where it names none."""
    return ReferenceSystem.of_text(source.crs.to_wkt(), where) if source.crs else None


def read_band(source, where, window):
    """Centres x (nx,), y (ny,) and heights z (ny, nx) of the first band, all ascending, in the file's units; NaN for no
    data. Scale and offset of the band are applied. A rotated or sheared raster is resampled, north up.

    window: function (x, y) -> slices of the columns and rows to keep, or a refusal. InputError: without a place on the
    map, not of real numbers, too large.
    """
    transform = source.transform
    if transform.is_identity or not np.isfinite(transform[:6]).all() or transform.determinant == 0.0:
        raise InputError(f"{where}: has no place on the map (no origin and cell size): give it one with a GIS")
    if np.dtype(source.dtypes[0]).kind not in "iuf":
        raise InputError(f"{where}: holds {source.dtypes[0]} values: must be real numbers")
    turned = bool(transform.b or transform.d)
    x, y = (_turned_centres if turned else _straight_centres)(source, where)
    columns, rows = window(x, y)
    x, y = x[columns], y[rows]
    if not len(x) or not len(y):
        return x, y, np.empty((len(y), len(x)))
    read_budget.allow(where, CELL_BYTES * float(len(x)) * len(y), f"{len(x)} x {len(y)} cells", ADVICE)
    if turned:
        return x, y, _sampled(source, where, x, y)
    first, last = columns.start, columns.stop
    if transform.a < 0.0:
        first, last = source.width - last, source.width - first
    top, bottom = rows.start, rows.stop
    if transform.e < 0.0:
        top, bottom = source.height - bottom, source.height - top
    z = _cells(source, where, (top, bottom), (first, last))
    return x, y, z[:: -1 if transform.e < 0.0 else 1, :: -1 if transform.a < 0.0 else 1]


def _straight_centres(source, where):
    """Centres, ascending, of a raster along the axes, whichever way its rows and columns run."""
    read_budget.allow(where, 32.0 * (source.width + source.height), f"{source.width} x {source.height} cells")
    t = source.transform
    return tuple(np.sort(start + step * (np.arange(n) + 0.5))
                 for start, step, n in ((t.c, t.a, source.width), (t.f, t.e, source.height)))


def _turned_centres(source, where):
    """Centres, ascending, of a raster along the axes that covers a turned one; cells as long as its shorter sides."""
    t = source.transform
    side = min(np.hypot(t.a, t.d), np.hypot(t.b, t.e))
    corners = np.array([[t.a * i + t.b * j + t.c, t.d * i + t.e * j + t.f]
                        for i in (0.5, source.width - 0.5) for j in (0.5, source.height - 0.5)])
    lower, upper = corners.min(axis=0), corners.max(axis=0)
    counts = np.floor((upper - lower) / side + 1e-6) + 1.0
    read_budget.allow(where, 16.0 * counts.sum(), f"{counts[0]:.6g} x {counts[1]:.6g} cells")
    return tuple(start + side * np.arange(int(n)) for start, n in zip(lower, counts, strict=True))


def _sampled(source, where, x, y):
    """Heights at the places x and y of a turned raster, bilinear between its centres; NaN beside missing cells."""
    from scipy.ndimage import map_coordinates  # slow to import

    back = ~source.transform
    xx, yy = np.meshgrid(x, y)
    column, row = (back.a * xx + back.b * yy + back.c - 0.5, back.d * xx + back.e * yy + back.f - 0.5)
    spans = [(max(int(np.floor(at.min())) - 1, 0), min(int(np.ceil(at.max())) + 2, n))
             for at, n in ((row, source.height), (column, source.width))]
    if any(first >= last for first, last in spans):
        return np.full(xx.shape, np.nan)
    z = _cells(source, where, *spans)
    near = [np.where(np.abs(at - np.round(at)) < 1e-6, np.round(at), at) - span[0]
            for at, span in zip((row, column), spans, strict=True)]  # at a centre, only this cell matters
    return map_coordinates(z, near, order=1, mode="constant", cval=np.nan)


def _cells(source, where, rows, columns):
    """Heights of a block of cells as they lie in the file."""
    from rasterio.windows import Window

    shape = rows[1] - rows[0], columns[1] - columns[0]
    block = np.prod(source.block_shapes[0], dtype=float) * source.count * np.dtype(source.dtypes[0]).itemsize
    read_budget.allow(where, CELL_BYTES * float(shape[0]) * shape[1] + block, f"{shape[1]} x {shape[0]} cells", ADVICE)
    z = source.read(1, window=Window.from_slices(rows, columns), masked=True).astype(float).filled(np.nan)
    no_data = [source.nodata] if source.nodata is not None else [USUAL_NO_DATA, *ends(source)]
    for value in no_data:
        if source.nodata is None and (bare := int((z == value).sum())):
            warnings.warn(f"{where}: {bare} cells hold {value:g}: taken as no data, which the file does not declare",
                          stacklevel=2)
        z[z == value] = np.nan
    z[~np.isfinite(z)] = np.nan
    return z * source.scales[0] + source.offsets[0]


def ends(source):
    """Smallest and largest number of a band of whole numbers that are scaled: what it holds where there is none, since
    it has no other number for that. None of bands as they are, where 255 may be a height."""
    kind = np.dtype(source.dtypes[0])
    if kind.kind not in "iu" or (source.scales[0], source.offsets[0]) == (1.0, 0.0):
        return []
    limits = np.iinfo(kind)
    return [float(limits.max), *([float(limits.min)] if kind.kind == "i" else [])]


def _require_tiff(file, path, key):
    try:
        with open(file, "rb") as stream:
            start = stream.read(4)
    except FileNotFoundError:
        if file == path:
            raise InputError.at(key, str(path), "cannot be read (no such file)") from None
        return
    except OSError as error:
        raise InputError.at(key, str(path), f"cannot be read ({error.strerror})") from error
    if start not in MAGIC:
        what = "is not a readable GeoTIFF" if file == path else f"has a mask {file.name} beside it that is no TIFF"
        raise InputError.at(key, str(path), what)
