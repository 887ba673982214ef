"""The folder of a region: its file, its own copies of what it reads, its release areas, and the runs to be done.

    region.toml, setting.json        the file; cells, coordinate system, digests, and the releases of each scenario
    terrain.tif, inputs/             copies of the terrain, forest, area of interest, rasters and layers
    areas_SCENARIO.gpkg              release areas with their attributes
    results.jsonl                    a line a run, as soon as it is done
    results/HH/HASH/                 numbers and maps of a run; HH: begin of its hash, so that no folder is huge
    maps/                            what is made of them
"""

import contextlib
import functools
import itertools
import json
import math
import shutil
import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import shapely
from scipy.stats import norm

from snowmpm import __version__, overwriting, plugins
from snowmpm.campaigns import design, untrusted
from snowmpm.draft import draft, write_text
from snowmpm.errors import InputError, shown_line
from snowmpm.io.projection import epsg_of
from snowmpm.reading.limited import read_text_limited
from snowmpm.reading.named_files import beside, digest_of
from snowmpm.region import elevations as windows
from snowmpm.region import release_areas as areas_of
from snowmpm.region import thickness
from snowmpm.region.elevations import BLOCK, open_elevations
from snowmpm.region.forest import open_forest
from snowmpm.region.polygons import polygons_of
from snowmpm.region.release_areas import LAYER, ReleaseArea
from snowmpm.region.spec import RegionFile, read_region
from snowmpm.scenes.friction_cards import friction_card
from snowmpm.scenes.toml import table_text
from snowmpm.seeding.region_files import SQLITE
from snowmpm.stages import counted, stage

FILE, SETTING, TERRAIN, BASE, RESULTS = "region.toml", "setting.json", "terrain.tif", "base.toml", "results.jsonl"
INPUTS, MAPS = "inputs", "maps"
USUAL_CELL = 5.0
"""Least side of the cells of the flow [m] where the file has none."""
FREE = ("cluster", "keep", "most_releases", "exposed", "pressures", "attribution", "zones")
"""Keys that may change when a region is resumed."""
MOST_SETTING = 64 << 20
OFF = 0.05
"""Share of a release polygon that may lie off the terrain; it is cut off."""
FRAMES = 20.0
"""Least time between frames [s]: nobody looks at them unless the runs are kept."""


@dataclass(frozen=True)
class Setting:
    """What all runs of a region share. file: `RegionFile`; folder; terrain, forest: files; interest: area of interest
    (shapely) or None; crs: name for GeoJSON, or None; wkt; cell [m] of flow and maps; areas: {scenario: numbers of its
    release areas}; digests: {key: of a file}."""

    file: RegionFile
    folder: Path
    terrain: Path
    forest: Path | None
    interest: Any
    crs: str | None
    wkt: str | None
    cell: float
    areas: dict[str, int]
    digests: dict[str, str]


def results_of(folder, name):
    """Folder of the results of a run by its hash."""
    return Path(folder) / "results" / name[:2] / name


def areas_file(folder, scenario):
    """File of the release areas of a scenario."""
    return Path(folder) / f"areas_{scenario}.gpkg"


@functools.lru_cache(maxsize=4)
def _setting(folder, stamp):
    folder = Path(folder)
    require_no_links(folder)
    with overwriting.looking():
        file = read_region(folder / FILE)
        _require_within(file)
    found = json.loads(read_text_limited(folder / SETTING, MOST_SETTING))
    interest = None
    forest = folder / file.forest.file if file.forest else None
    with open_elevations(folder / TERRAIN) as elevations:
        system = elevations.grid.system
    if file.area_of_interest:
        interest = interest_of(folder / file.area_of_interest, system)
    cell, areas, digests = float(found["cell"]), found["areas"], found["digests"]
    if not 0.0 < cell < 1e5 or set(areas) != set(file.scenarios) or not all(
            type(n) is int and 0 < n < 2**31 for n in areas.values()) or not all(
            isinstance(text, str) for text in digests.values()):
        raise ValueError("numbers that cannot be")
    return Setting(file, folder, folder / TERRAIN, forest, interest, found["crs"], system and system.wkt, cell, areas,
                   digests)


def require_no_links(folder):
    """Raise InputError for a folder in which other folders are links: it may come from anybody."""
    untrusted.require_no_links(folder)
    maps = Path(folder) / MAPS
    for path in (Path(folder) / INPUTS, maps, *(maps.iterdir() if maps.is_dir() and not maps.is_symlink() else ())):
        if path.is_symlink():
            raise InputError(f"{path}: is a link, and a region is written to folders of its own")


def _require_within(file):
    """Raise InputError for a region that names files outside of its folder: it may come from anybody."""
    exposed = {f"exposed.{k}": file.path(one) for k, one in enumerate(file.exposed)}
    for key, path in {**sources(file), **exposed}.items():
        if path != file.base_dir / TERRAIN and (path.parent != file.base_dir / INPUTS or path.is_symlink()):
            raise InputError(f"{file.source}: {key}: must lie in {INPUTS}/ of its folder")


def read_setting(folder):
    """`Setting` of a folder. Raises InputError for one that holds no region, or a damaged one."""
    path = Path(folder) / SETTING
    if not path.is_file():
        raise InputError(f"{folder}: no region here ({SETTING} is missing)")
    try:
        return _setting(str(Path(folder).resolve()), path.stat().st_mtime_ns)
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        raise InputError(f"{path}: not written by this program ({type(error).__name__})") from None


def interest_of(path, system):
    """The area of interest, one geometry. InputError."""
    return shapely.union_all([one.geometry for one in polygons_of(Path(path), "area_of_interest", system)])


def read_area(folder, scenario, number):
    """`ReleaseArea` of a scenario by its number. Raises InputError for a file that this program did not write."""
    import pyogrio

    path = _areas_file(folder, scenario)
    try:
        meta, _, geometry, values = pyogrio.raw.read(str(path), layer=LAYER, fids=np.array([number]))
        found = {name: column[0] for name, column in zip(meta["fields"], values, strict=True)}
        return _area_from(shapely.from_wkb(geometry[0]), found)
    except (pyogrio.errors.DataSourceError, pyogrio.errors.FeatureError, KeyError, IndexError, ValueError) as error:
        raise InputError(f"{path}: has no release area {number} ({shown_line(error, 100)})") from None


def _areas_file(folder, scenario):
    """The file of the release areas; InputError for one that is none: GDAL must not open it as any other format."""
    path = areas_file(folder, scenario)
    if not path.is_file() or path.is_symlink() or not path.open("rb").read(len(SQLITE)) == SQLITE:
        raise InputError(f"{path}: not written by this program")
    return path


def _area_from(geometry, found):
    thick = found["thickness"]
    return ReleaseArea(int(found["id"]), geometry, *(float(found[name]) for name in (
        "area_m2", "surface_m2", "slope_deg", "aspect_deg", "altitude_m", "lowest_m", "highest_m", "forest_share")),
        None if thick is None or not thick > 0.0 else float(thick))


def read_areas(folder, scenario):
    """All `ReleaseArea`s of a scenario, one after the other."""
    import pyogrio

    meta, _, geometry, values = pyogrio.raw.read(str(_areas_file(folder, scenario)), layer=LAYER)
    for k, one in enumerate(geometry):
        yield _area_from(shapely.from_wkb(one), {
            name: column[k] for name, column in zip(meta["fields"], values, strict=True)})


def factors(samples):
    """(thickness, friction) factors of each sample: a Latin hypercube of logarithms."""
    if samples.runs == 1:
        return [(1.0, 1.0)]
    score = norm.ppf(design.shares("latin_hypercube", samples.runs, 2, samples.seed))
    found = np.exp(score * [samples.thickness, samples.friction])
    return [tuple(float(f"{value:.9g}") for value in row) for row in found]


def chosen(count, most):
    """Numbers, from 1, of `most` of `count` release areas, spread evenly; a larger choice holds a smaller one."""
    if most is None or most >= count:
        return range(1, count + 1)
    bits = max(1, (count - 1).bit_length())
    order = (int(f"{k:0{bits}b}"[::-1], 2) for k in range(2**bits))  # van der Corput's
    return sorted(itertools.islice((1 + k for k in order if k < count), most))


def wanted(setting):
    """Hashes, as whole numbers, of all runs that the file asks for (n,)."""
    return np.fromiter((int(job.hash, 16) for job in jobs(setting)), np.uint64)


def jobs(setting):
    """`RegionJob` of every run, made one after the other."""
    from snowmpm.region.jobs import RegionJob, hash_of

    file = setting.file
    loaded = tuple((one.source, one.sha256) for one in plugins.loaded() if one.source)
    card = friction_card(file.friction.card).model_dump(mode="json") if file.friction.card else None
    shared = (__version__, plugins.records(), setting.digests, card, setting.cell,
              file.model_dump(mode="json", include={"flow", "friction", "forest"}))
    drawn = factors(file.samples)
    for scenario, count in setting.areas.items():
        own = hash_of(shared, scenario, file.scenarios[scenario].model_dump(mode="json"))
        for number in chosen(count, file.most_releases):
            for sample, (thick, rubs) in enumerate(drawn):
                name = hash_of(own, number, thick, rubs)
                yield RegionJob(name, str(setting.folder), scenario, number, sample, thick, rubs, file.keep,
                                file.cluster.threads, loaded, file.cluster.backend)


def count_of(setting):
    """Number of runs."""
    return sum(len(chosen(count, setting.file.most_releases)) for count in setting.areas.values()
               ) * setting.file.samples.runs


def sources(file):
    """{key: file} of what the runs of a region read, but for its own file."""
    found = {"terrain": file.path(file.terrain)}
    if file.forest:
        found["forest"] = file.path(file.forest.file)
    if file.area_of_interest:
        found["area_of_interest"] = file.path(file.area_of_interest)
    for name, one in file.scenarios.items():
        if one.file:
            found[f"scenarios.{name}.file"] = file.path(one.file)
        if one.thickness and one.thickness.file:
            found[f"scenarios.{name}.thickness.file"] = file.path(one.thickness.file)
    return found


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
    _setting.cache_clear()


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
