"""The folder of a region: its file, its own copies of what it reads, its release areas, and the runs to be done.

    region.toml, setting.json        the file; cells, coordinate system, digests, and the releases of each scenario
    terrain.tif, inputs/             copies of the terrain, forest, area of interest, rasters and layers
    areas_SCENARIO.gpkg              release areas with their attributes
    results.jsonl                    a line a run, as soon as it is done
    results/HH/HASH/                 numbers and maps of a run; HH: begin of its hash, so that no folder is huge
    maps/                            what is made of them
"""

import functools
import itertools
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import shapely
from scipy.stats import norm

from snowmpm import __version__, overwriting, plugins
from snowmpm.campaigns import design, untrusted
from snowmpm.errors import InputError, shown_line
from snowmpm.reading.limited import read_text_limited
from snowmpm.region.elevations import open_elevations
from snowmpm.region.polygons import polygons_of
from snowmpm.region.release_areas import LAYER, ReleaseArea
from snowmpm.region.spec import RegionFile, read_region
from snowmpm.scenes.friction_cards import friction_card
from snowmpm.seeding.region_files import SQLITE

FILE, SETTING, TERRAIN, BASE, RESULTS = "region.toml", "setting.json", "terrain.tif", "base.toml", "results.jsonl"
INPUTS, MAPS = "inputs", "maps"
MOST_SETTING = 64 << 20


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


def forget():
    """Forget settings that were read: their files have changed."""
    _setting.cache_clear()


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
