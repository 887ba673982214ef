"""Which map projection the coordinates of a file are in."""

from pathlib import Path


def reference_system(paths):
    """Well-known text (WKT) of the projection that the first of the files names; None when none does.

    A .tif says it itself; of an .asc or a .shp the .prj file beside it does, as other programs write it.
    """
    for path in map(Path, paths):
        text = _of_geotiff(path) if path.suffix.lower() in (".tif", ".tiff") else _beside(path)
        if text:
            return text
    return None


def _of_geotiff(path):
    # Whoever has read the elevations of a .tif has rasterio
    import rasterio

    with rasterio.open(path) as source:
        return source.crs.to_wkt() if source.crs else None


def _beside(path):
    projection = path.with_suffix(".prj")
    return projection.read_text(encoding="utf-8", errors="replace").strip() if projection.is_file() else None
