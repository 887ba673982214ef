"""What reaches each building, road or other feature: exposed.csv and exposed.gpkg, the largest over its cells."""

import csv
from pathlib import Path

import numpy as np
import shapely

from snowmpm.draft import draft
from snowmpm.errors import InputError
from snowmpm.gis.layers import Layer
from snowmpm.gis.vectors import write_geopackage
from snowmpm.region.elevations import CACHE
from snowmpm.region.jobs import MAPPED
from snowmpm.seeding.region_files import PLACE, POLYGON, read_features
from snowmpm.stages import counted
from snowmpm.terrain.reference_system import ReferenceSystem

TABLE, OUTLINES = "exposed.csv", "exposed.gpkg"


def write(setting, folder):
    """Write the table and the layer of all features; -> the paths, [] without `exposed` layers."""
    rows, shapes = [], []
    for file in setting.file.exposed:
        for geometry, row in _of_file(setting, setting.folder / file, Path(folder)):
            rows.append(row)
            shapes.append(geometry)
    if not rows:
        return []
    rows_and_shapes = sorted(zip(rows, shapes, strict=True), key=lambda one: (
        -one[0]["class"], -(one[0]["frequency"] or 0.0), one[0]["layer"], one[0]["feature"]))
    with draft(Path(folder) / TABLE) as part, part.open("w", newline="", encoding="utf-8") as file:
        table = csv.DictWriter(file, list(rows[0]), lineterminator="\n")
        table.writeheader()
        table.writerows({key: _cell(value) for key, value in row.items()} for row, _ in rows_and_shapes)
    layers = [Layer(f"exposed_{kind.lower()}", kind, own) for kind in ("MultiPolygon", "MultiLineString", "MultiPoint")
              if (own := [(shape, row) for row, shape in rows_and_shapes if shape.geom_type == kind])]
    return [Path(folder) / TABLE, write_geopackage(Path(folder) / OUTLINES, layers, setting.wkt)]


def _cell(value):
    if isinstance(value, str) and value[:1] in "=+-@\t\r" and value:  # a spreadsheet would compute it
        return f"'{value}"
    return "" if value is None else f"{value:.5g}" if isinstance(value, float) else value


def _features(path, key, system):
    """(geometry, name) of each feature of a layer of polygons, or of lines and points."""
    try:
        for feature in read_features(path, key, system):
            yield shapely.MultiPolygon([shapely.Polygon(rings[0], rings[1:]) for rings in feature.parts]), feature.name
        return
    except InputError as error:
        if f"no {POLYGON.single}" not in str(error) and "polygon" not in str(error):
            raise
    for feature in read_features(path, key, system, kind=PLACE):
        lines = [np.asarray(part) for part in feature.parts]
        yield (shapely.MultiPoint(np.concatenate(lines)) if all(len(line) == 1 for line in lines)
               else shapely.MultiLineString([line for line in lines if len(line) > 1])), feature.name


def _of_file(setting, path, folder):
    """(geometry, row) of each feature of a layer."""
    import rasterio
    from rasterio.features import geometry_mask

    system = ReferenceSystem.of_text(setting.wkt, "terrain") if setting.wkt else None
    names = {f"{kind}_{name}": (name, kind) for name in setting.file.scenarios for kind in (*MAPPED, "intensity")}
    label = path.stem.partition("_")[2] or path.stem
    with rasterio.Env(GDAL_CACHEMAX=CACHE):
        zones = ("zones",) if setting.file.zones else ()
        files = {name: rasterio.open(folder / f"{name}.tif") for name in (*names, *zones, "frequency")}
        try:
            every = list(_features(path, "exposed", system))
            for number, (geometry, name) in enumerate(counted(every, f"looking at {label}", "features"), 1):
                row = {"layer": label, "feature": number, "name": name, "class": 0, "frequency": None}
                window, inside = _window(geometry, files["frequency"], geometry_mask)
                for key, file in files.items():
                    values = _largest(file, window, inside)
                    if key == "frequency":
                        row["frequency"] = values
                    elif key == "zones":
                        row["zone"] = int(values or 0)
                    elif key.startswith("intensity"):
                        row["class"] = max(row["class"], int(values or 0))
                        row[key] = int(values or 0)
                    else:
                        row[key] = values
                yield geometry, row
        finally:
            for file in files.values():
                file.close()


def _window(geometry, file, geometry_mask):
    """(window, mask of the cells that a geometry touches) in a raster; (None, None) beside it."""
    from rasterio.windows import Window

    west, south, east, north = geometry.bounds
    transform = file.transform
    first = max(0, int((transform.f - north) / transform.a)), max(0, int((west - transform.c) / transform.a))
    last = (min(file.height, int((transform.f - south) / transform.a) + 1),
            min(file.width, int((east - transform.c) / transform.a) + 1))
    if first[0] >= last[0] or first[1] >= last[1]:
        return None, None
    window = Window.from_slices((first[0], last[0]), (first[1], last[1]))
    inside = geometry_mask([geometry], (last[0] - first[0], last[1] - first[1]),
                           file.window_transform(window), all_touched=True, invert=True)
    return window, inside


def _largest(file, window, inside):
    """Largest value of a raster within a mask; None where it has none."""
    if window is None or not inside.any():
        return None
    values = file.read(1, window=window, masked=True)
    found = values[inside & ~np.ma.getmaskarray(values)]
    return float(f"{float(found.max()):.6g}") if found.size else None
