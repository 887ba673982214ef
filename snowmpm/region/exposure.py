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
        -(one[0]["class"] or 0), -(one[0]["frequency"] or 0.0), one[0]["layer"], one[0]["feature"]))
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
    return "" if value is None else f"{value:.4g}" if isinstance(value, float) else value


def features_of(path, key, system):
    """List of (geometry, name) of the polygons, lines and points of a layer. InputError for one without any."""
    found, refused = [], None
    for kind, options in ((POLYGON, {"named": True}), (PLACE, {"kind": PLACE})):
        try:
            features = read_features(path, key, system, **options)
        except InputError as error:
            # A layer holds one kind as a rule; another fault is told for both
            if kind is PLACE and not found:
                raise (refused if refused is not None and kind.single in str(error) else error) from None
            refused = error
            continue
        found += [(_geometry(feature, kind), feature.name) for feature in features]
    return found


def _geometry(feature, kind):
    if kind is POLYGON:
        return shapely.MultiPolygon([shapely.Polygon(rings[0], rings[1:]) for rings in feature.parts])
    lines = [np.asarray(part) for part in feature.parts]
    if all(len(line) == 1 for line in lines):
        return shapely.MultiPoint(np.concatenate(lines))
    return shapely.MultiLineString([line for line in lines if len(line) > 1])


def _of_file(setting, path, folder):
    """(geometry, row) of each feature of a layer. class is None where a feature lies outside of the map, or of the area
    of interest and is not reached: then nobody knows."""
    import rasterio
    from rasterio.features import geometry_mask

    system = ReferenceSystem.of_text(setting.wkt, "terrain") if setting.wkt else None
    label = path.stem.partition("_")[2] or path.stem
    names = [f"{kind}_{name}" for name in setting.file.scenarios for kind in ("intensity", *MAPPED, "probability")]
    zones = ["zones"] if setting.file.zones else []
    with rasterio.Env(GDAL_CACHEMAX=CACHE):
        files = {name: rasterio.open(folder / f"{name}.tif") for name in (*names, *zones, "frequency", "arrivals")}
        try:
            every = features_of(path, "exposed", system)
            for number, (geometry, name) in enumerate(counted(every, f"looking at {label}", "features"), 1):
                window, inside = _window(geometry, files["frequency"], geometry_mask)
                values = {key: _largest(file, window, inside) for key, file in files.items()}
                known = inside is not None and inside.any() and (
                    setting.interest is None or geometry.intersects(setting.interest) or values["frequency"])
                yield geometry, _row(setting, {"layer": label, "feature": number, "name": name}, values, known)
        finally:
            for file in files.values():
                file.close()


def _row(setting, about, values, known):
    """A row of the table: pressures in kPa."""
    classes = [int(values[f"intensity_{name}"] or 0) for name in setting.file.scenarios]
    frequency = values["frequency"]
    row = {**about, "class": max(classes) if known else None}
    if setting.file.zones:
        row["zone"] = int(values["zones"] or 0) if known else None
    row |= {"frequency": frequency, "once_in_years": float(f"{1.0 / frequency:.3g}") if frequency else None,
            "arrivals": values["arrivals"]}
    for name in setting.file.scenarios:
        pressure = values[f"peak_pressure_{name}"]
        row |= {f"depth_m_{name}": values[f"peak_depth_{name}"], f"speed_m_s_{name}": values[f"peak_speed_{name}"],
                f"pressure_kpa_{name}": None if pressure is None else float(f"{pressure / 1e3:.4g}"),
                f"probability_{name}": values[f"probability_{name}"]}
    return row


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
