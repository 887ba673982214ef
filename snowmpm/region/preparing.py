"""Making the folder of a region: bad input refused, release areas found, files copied; and resuming it."""

import contextlib
import json
import math
import shutil
import warnings
from pathlib import Path

import numpy as np
import shapely

from snowmpm.draft import draft, write_text
from snowmpm.errors import InputError
from snowmpm.io.projection import epsg_of
from snowmpm.reading.named_files import beside, digest_of
from snowmpm.region import elevations as windows
from snowmpm.region import release_areas as areas_of
from snowmpm.region import thickness
from snowmpm.region.elevations import BLOCK, open_elevations
from snowmpm.region.forest import open_forest
from snowmpm.region.plan import (
    BASE,
    FILE,
    INPUTS,
    MAPS,
    RESULTS,
    SETTING,
    TERRAIN,
    Setting,
    areas_file,
    forget,
    interest_of,
    read_setting,
    sources,
)
from snowmpm.region.polygons import polygons_of
from snowmpm.scenes.toml import table_text
from snowmpm.stages import counted, stage

USUAL_CELL = 5.0
"""Least side of the cells of the flow [m] where the file has none."""
FREE = ("cluster", "keep", "most_releases", "exposed", "pressures", "attribution", "zones")
"""Keys that may change when a region is resumed."""
OFF = 0.05
"""Share of a release polygon that may lie off the terrain; it is cut off."""
FRAMES = 20.0
"""Least time between frames [s]: nobody looks at them unless the runs are kept."""


def cell_of(file, grid):
    """Side [m] of the cells of the flow. InputError."""
    if file.flow.cell is None:
        return grid.cell * max(1, math.ceil(USUAL_CELL / grid.cell - 1e-9))
    ratio = file.flow.cell / grid.cell
    if file.flow.cell * 20.0 > min(grid.rows, grid.columns) * grid.cell:
        raise InputError.at("flow.cell", file.flow.cell, "is too large: the terrain has fewer than 20 cells across",
                            file=file.source)
    if abs(ratio - round(ratio)) > 1e-6 * ratio or round(ratio) < 1:
        raise InputError.at("flow.cell", file.flow.cell, f"must be a whole multiple of the terrain's cells of"
                                                         f" {grid.cell:g} m", file=file.source)
    return grid.cell * round(ratio)


def require_same(file, folder):
    """Raise InputError where a folder holds another region than the file, or files that it names have changed."""
    own = read_setting(folder)
    before, now = (_compared(one) for one in (own.file, file))
    for key in dict.fromkeys([*before, *now]):
        if before.get(key) != now.get(key):
            raise InputError(f"{file.source}: {key}: is not that of the region in {folder}, which --resume completes:"
                             "\nchoose another folder with -o")
    for key, path in sources(file).items():
        if digest_of(path) != own.digests.get(key):
            raise InputError(f"{file.source}: {key} = {str(path)!r}: has changed since the region in {folder} began:"
                             "\nchoose another folder with -o")


def _compared(file):
    """What a region that is resumed must share, without the names of files, which are copied."""
    found = file.model_dump(mode="json", exclude=set(FREE))
    for key in ("terrain", "area_of_interest"):
        found[key] = bool(found[key])
    if found["forest"]:
        found["forest"]["file"] = True
    for one in found["scenarios"].values():
        one["file"] = bool(one["file"])
        if one["thickness"]:
            one["thickness"]["file"] = bool(one["thickness"]["file"])
    return found


def make(file, folder, copies=True):
    """Find the release areas of a `RegionFile`, and write its folder; -> `Setting`. Raises InputError for bad input,
    before anything is written. copies: whether files are copied to it; without, nothing can be run from it."""
    folder = Path(folder).resolve()
    given = sources(file)
    with stage("reading files"):
        digests = {key: digest_of(path) for key, path in given.items()}
    _require_own(folder)
    folder.mkdir(parents=True, exist_ok=True)
    scratch = folder / ".making"
    shutil.rmtree(scratch, ignore_errors=True)
    scratch.mkdir()
    try:
        source = windows.as_geotiff(given["terrain"], scratch)
        with open_elevations(source) as elevations:
            grid = elevations.grid
            if grid.system is None:
                warnings.warn(f"{file.source}: terrain = {file.terrain!r}: names no coordinate system: forest, layers"
                              " and areas are taken as in the same one", stacklevel=2)
            cell = cell_of(file, grid)
            with open_forest(given.get("forest"), grid, file.forest.cover if file.forest else 0.0,
                             "forest.file") as forest:
                for k, layer in enumerate(file.exposed):
                    _require_exposed(file.path(layer), f"exposed.{k}", grid, file)
                if file.area_of_interest:
                    _require_inside(interest_of(given["area_of_interest"], grid.system), grid, file)
                found = {name: _areas(file, name, elevations, forest, scratch) for name in file.scenarios}
            for name, areas in found.items():
                areas_of.write(areas, areas_file(folder, name), name, grid.system)
            if copies or source != given["terrain"]:
                _copy_terrain(elevations, folder / TERRAIN)
                source = folder / TERRAIN
    finally:
        shutil.rmtree(scratch, ignore_errors=True)
        with contextlib.suppress(OSError):  # where nothing came of it
            folder.rmdir()
    code = grid.system and epsg_of(grid.system.wkt)
    crs = f"urn:ogc:def:crs:EPSG::{code}" if code else None
    counts = {name: len(areas) for name, areas in found.items()}
    write_text(folder / BASE, _base(file, cell, source))
    if not copies:
        return Setting(file, folder, source, given.get("forest"), None, crs, grid.system and grid.system.wkt, cell,
                       counts, digests)
    write_text(folder / FILE, table_text(_with_copies(file, folder)))
    write_text(folder / SETTING, json.dumps({"cell": cell, "crs": crs, "digests": digests, "areas": counts}, indent=1))
    return read_setting(folder)


def _require_own(folder):
    """Raise InputError for a folder that holds files of somebody else."""
    if folder.is_dir() and (strange := sorted(one.name for one in folder.iterdir() if not one.name.startswith("."))):
        own = {FILE, SETTING, TERRAIN, BASE, RESULTS, INPUTS, MAPS, "results", "runs"}
        others = [name for name in strange if name not in own and not name.startswith("areas_")]
        if others or not (folder / ".snowmpm-files").exists():
            raise InputError(f"-o {folder}: holds files of others, such as {(others or strange)[0]}: choose another"
                             " folder")


def rewrite(file, folder):
    """Take over the keys of a file that may change when a region is resumed."""
    folder, setting = Path(folder), read_setting(folder)
    own = setting.file.model_dump(exclude_none=True, exclude_defaults=True)
    new = file.model_dump(exclude_none=True, exclude_defaults=True)
    kept = {key: value for key, value in own.items() if key not in FREE}
    for key in FREE:
        if key in new:
            kept[key] = [_copied(file.path(one), folder) for one in new[key]] if key == "exposed" else new[key]
    write_text(folder / FILE, table_text(kept | {"name": file.name}))
    forget()


def write_base(setting):
    """Write the scene that all runs change."""
    write_text(setting.folder / BASE, _base(setting.file, setting.cell, setting.terrain))


def _require_inside(interest, grid, file):
    if not interest.intersects(shapely.box(*grid.bounds)):
        raise InputError.at("area_of_interest", file.area_of_interest, "lies beside the terrain: is its coordinate"
                                                                       " system right?", file=file.source)


def _require_exposed(path, key, grid, file):
    """Raise InputError for a layer that cannot be read, or lies beside the terrain."""
    from snowmpm.region.exposure import features_of

    box = shapely.box(*grid.bounds)
    if not any(geometry.intersects(box) for geometry, _ in features_of(path, key, grid.system)):
        raise InputError.at(key, path.name, "lies beside the terrain: is its coordinate system right?",
                            file=file.source)


def _areas(file, name, elevations, forest, scratch):
    """`ReleaseArea`s of a scenario, with their thickness. InputError."""
    scenario = file.scenarios[name]
    where = f"{file.source}: scenarios.{name}"
    if scenario.file is None:
        found = areas_of.release_areas(elevations, scenario.rule, forest, file.forest.protects if file.forest else True,
                                       scratch=scratch)
    else:
        found = _given(file.path(scenario.file), elevations, scenario, where)
    if not found:
        raise InputError(f"{where}: no release areas: no ground from {scenario.rule.least:g} to"
                         f" {scenario.rule.most:g} degrees is large enough")
    if scenario.thickness is None:
        return found
    mean = None
    if scenario.thickness.file:
        mean = _mean_over(file.path(scenario.thickness.file), where, elevations.grid.system)
    return [thickness.of(one, scenario.thickness, mean) for one in found]


def _given(path, elevations, scenario, where):
    """`ReleaseArea`s of the polygons of a file."""
    found, ground = [], shapely.box(*elevations.grid.bounds)
    for number, one in enumerate(polygons_of(path, f"{where}.file", elevations.grid.system), 1):
        geometry = one.geometry
        off = geometry.difference(ground).area / geometry.area
        if off > OFF:
            raise InputError(f"{where}.file = {path.name!r}: polygon {number}: {100 * off:.3g} % of it lies off the"
                             " terrain")
        if scenario.thickness is None and one.thickness is None:
            raise InputError(f"{where}.thickness: is missing: {one.flaw}")
        if scenario.thickness is None and one.thickness > thickness.MOST:
            raise InputError(f"{where}.file: thickness = {one.thickness:g} m: must be at most {thickness.MOST:g} m")
        found.append(areas_of.described(number, geometry, elevations, one.thickness, f"{where}.file"))
    return found


def _mean_over(path, where, system):
    """Function of a geometry -> mean of a raster over it. InputError."""
    from rasterio.features import geometry_mask

    if path.suffix.lower() not in (".tif", ".tiff"):
        raise InputError.at(f"{where}.thickness.file", str(path), "must be a GeoTIFF (.tif)")

    def mean(geometry):
        with open_elevations(path, f"{where}.thickness.file") as source:
            own = source.grid
            corners = np.array(own.bounds).reshape(2, 2)
            if own.system is not None and system is not None and not np.allclose(
                    own.system.carried(corners, system), corners, atol=0.1):
                raise InputError.at(f"{where}.thickness.file", str(path), f"is in {own.system.name}, and the terrain in"
                                                                          f" {system.name}: gdalwarp -t_srs")
            west, south, east, north = geometry.bounds
            rows, columns = own.rows_of(south, north), own.columns_of(west, east)
            values = source.read(rows, columns)
            inside = geometry_mask([geometry], values.shape, own.transform(rows[0], columns[0]), all_touched=True,
                                   invert=True) & np.isfinite(values) & (values >= 0.0)
        if not inside.any() or not 0.0 < values[inside].mean() <= thickness.MOST:
            raise InputError.at(f"{where}.thickness.file", str(path),
                                f"holds no thickness from 0 to {thickness.MOST:g} m at x = {west:.0f} m, y ="
                                f" {south:.0f} m, where an area lies")
        return float(f"{values[inside].mean():.6g}")

    return mean


def _copy_terrain(elevations, path):
    """Copy the terrain as blocks."""
    grid = elevations.grid
    spans = [((r, min(r + 4 * BLOCK, grid.rows)), (c, min(c + 4 * BLOCK, grid.columns)))
             for r in range(0, grid.rows, 4 * BLOCK) for c in range(0, grid.columns, 4 * BLOCK)]
    windows.write_blocks(path, grid, ((rows, columns, elevations.read(rows, columns))
                                      for rows, columns in counted(spans, "copying the terrain", "blocks")),
                         "elevation", "m", overviews=True)


def _with_copies(file, folder):
    """Tables of a file that names the copies in the folder, which are made."""
    found = file.model_dump(exclude_none=True, exclude_defaults=True) | {"name": file.name}
    found["terrain"] = TERRAIN
    if file.forest:
        found["forest"]["file"] = _copied(file.path(file.forest.file), folder)
    if file.area_of_interest:
        found["area_of_interest"] = _copied(file.path(file.area_of_interest), folder)
    if file.exposed:
        found["exposed"] = [_copied(file.path(one), folder) for one in file.exposed]
    for name, one in file.scenarios.items():
        if one.file:
            found["scenarios"][name]["file"] = _copied(file.path(one.file), folder)
        if one.thickness and one.thickness.file:
            found["scenarios"][name]["thickness"]["file"] = _copied(file.path(one.thickness.file), folder)
    return found


def _copied(path, folder):
    """Name, relative to the folder, of a copy of a file and of those that belong to it."""
    name = f"{digest_of(path)[:8]}_{path.name}"
    for own in (path, *beside(path)):
        ending = own.name[len(path.name):] if own.name.startswith(path.name) else own.suffix
        target = Path(folder) / INPUTS / (f"{name}{ending}" if own.name.startswith(path.name)
                                          else f"{Path(name).stem}{ending}")
        if not target.is_file():
            with draft(target) as part:
                shutil.copyfile(own, part)
    return f"{INPUTS}/{name}"


def _base(file, cell, terrain):
    """The scene that all runs change; terrain: its file."""
    scene = {
        "name": file.name, "dimension": 3, "end_time": file.flow.end_time,
        "output": {"interval": max(FRAMES, file.flow.end_time / 20.0), "map_cell": cell},
        "solver": {"method": "depth", "dx": cell},
        "terrain": {"kind": "dem", "file": TERRAIN if terrain.name == TERRAIN else str(terrain), "friction": 0.3},
        "materials": {"snow": {"kind": "elastic", "density": file.flow.density, "youngs_modulus": 1e6,
                               "poisson_ratio": 0.3}},
        "bodies": [{"name": "release", "material": "snow", "shape": {
            "kind": "layer", "bottom": 0.0, "top": 1.0, "region": {"x": [0.0, 1.0]}}}]}
    if file.attribution:
        scene["terrain"]["attribution"] = file.attribution
    return table_text(scene)
