"""Maps over all runs of a region, made tile by tile: no array of the whole region is in memory.

Of each scenario, in maps/: the largest depth, speed and pressure of all runs, the class of intensity, how many releases
reach a cell, and how probable it is that one does. A release reaches a cell in a share p of its samples; releases are
independent:

    P = 1 - product over releases of (1 - p)

Over all scenarios: how often a year a cell is reached at least once, and with more than each pressure. A scenario of
the return period T stands for the years from T to that of the next one, and holds all that the more frequent ones hold:

    frequency = sum over scenarios, by growing T, of max over j <= k of P_j (1 / T_k - 1 / T_k+1),
    1 / T = 0 after the last; scenarios of one T are joined: P = 1 - product of (1 - P)

That takes all releases of a return period for one event, and is a lower bound. arrivals is the upper one: the same sum
with the expected number of releases that come, sum of p, in place of P, as if each came in a year of its own.

Cloud-optimised GeoTIFFs with overviews, and maps.zarr over scenario, y and x.
"""

import contextlib
import warnings
from dataclasses import dataclass

import numpy as np

from snowmpm import overwriting
from snowmpm.campaigns import untrusted
from snowmpm.campaigns.work import MAPS as RUN_MAPS
from snowmpm.draft import draft
from snowmpm.io.geotiff import NO_DATA, require_rasterio
from snowmpm.quantities.quantity import written
from snowmpm.region import launch, plan
from snowmpm.region.elevations import CACHE, lattice, open_elevations, profile_of
from snowmpm.region.jobs import MAPPED
from snowmpm.region.zones import ZONES, zones_of
from snowmpm.stages import counted

TILE = 512
"""Side of a tile [cells]."""
STORE = "maps.zarr"
ZONE = "zones"
UNITS = {"peak_depth": "m", "peak_speed": "m/s", "peak_pressure": "Pa"}


@dataclass(frozen=True)
class Raster:
    """A map: name; scenario or None; kind: of numbers; unit; meaning; overview: how coarser levels are made."""

    name: str
    scenario: str | None
    kind: str
    unit: str
    meaning: str
    overview: str = "AVERAGE"


def rasters(setting):
    """List of `Raster`s of a `plan.Setting`."""
    found, limits = [], ", ".join(written(p, "Pa") for p in setting.file.pressures)
    for name, one in setting.file.scenarios.items():
        years = f"{one.period:g} years"
        found += [Raster(f"{kind}_{name}", name, "float32", UNITS[kind],
                         f"{kind.replace('_', ' ')} over all runs, {years}") for kind in MAPPED]
        found += [Raster(f"intensity_{name}", name, "uint8", "class", f"class of peak pressure, divided at {limits};"
                                                                      f" 0: not reached; {years}", "MODE"),
                  Raster(f"releases_{name}", name, "float32", "number", f"releases that reach the cell, {years}"),
                  Raster(f"probability_{name}", name, "float32", "share", f"probability of being reached, {years}")]
    found += [Raster(key, None, "float32", "1/year", f"frequency {words}") for key, words in _frequencies(setting)]
    found.append(Raster("arrivals", None, "float32", "1/year", "expected number of arrivals, each release by itself"))
    if setting.file.zones:
        names = ", ".join(f"{k}: {name}" for k, name in enumerate(ZONES[setting.file.zones].names, 1))
        found.append(Raster(ZONE, None, "uint8", "zone", f"zones of {setting.file.zones}; {names}", "MODE"))
    return found


def _frequencies(setting):
    """(name, words) of the maps of frequency."""
    yield "frequency", "of being reached at least once"
    for p in setting.file.pressures:
        yield f"frequency_above_{p / 1e3:.10g}_kPa", f"of at least {written(p, 'Pa')}"


def grid_of(setting):
    """`Grid` of the maps: cells of the flow that cover the terrain."""
    with open_elevations(setting.terrain) as elevations:
        return lattice(elevations.grid, setting.cell)


def write_all(setting):
    """Write everything that is made of the runs: maps, outlines, tables, page, project; -> the folder of the maps."""
    from snowmpm.region import exposure, outlines, page, project, releases

    folder = setting.folder / plan.MAPS
    folder.mkdir(exist_ok=True)
    overwriting.note_changing(folder)
    overwriting.note_changing(folder / STORE)
    _remove_stale(setting, folder)
    index = launch.index(setting)
    grid = grid_of(setting)
    write_maps(setting, index, grid, folder)
    outlines.write(setting, folder)
    releases.write(setting, index, folder)
    exposure.write(setting, folder)
    project.write(setting, folder)
    page.write(setting, index, folder)
    return folder


def _remove_stale(setting, folder):
    """Remove what an earlier run of this folder wrote, and this one does not, such as maps of other pressures."""
    from snowmpm.region import exposure

    kept = {f"{one.name}.tif" for one in rasters(setting)}
    stale = [one for one in folder.glob("*.tif") if one.name not in kept]
    if not setting.file.exposed:
        stale += [one for name in (exposure.TABLE, exposure.OUTLINES) if (one := folder / name).exists()]
    overwriting.guard(*stale)
    for one in stale:
        one.unlink()


def write_maps(setting, index, grid, folder):
    """Write the GeoTIFFs and the Zarr store of a `journal.Index`."""
    rasterio = require_rasterio()
    from rasterio.windows import Window

    wanted = rasters(setting)
    with contextlib.ExitStack() as stack:
        stack.enter_context(rasterio.Env(GDAL_CACHEMAX=CACHE))
        parts = {one.name: stack.enter_context(draft(folder / f"{one.name}.tif")) for one in wanted}
        plain = {name: part.with_suffix(".plain.tif") for name, part in parts.items()}
        for one in plain.values():
            stack.callback(one.unlink, missing_ok=True)
        with contextlib.ExitStack() as files:
            open_files = {one.name: files.enter_context(
                rasterio.open(plain[one.name], "w", **profile_of(grid, one.kind))) for one in wanted}
            store = _Store(setting, grid, wanted, folder / STORE)
            for rows, columns in counted(tiles(grid), "putting maps together", "tiles"):
                found = tile_of(setting, index, grid, rows, columns)
                if found is None:
                    continue
                for name, values in found.items():
                    open_files[name].write(values, 1, window=Window.from_slices(rows, columns))
                store.put(rows, columns, found)
            store.close()
            for one in wanted:
                open_files[one.name].set_band_description(1, one.meaning)
                open_files[one.name].units = (one.unit,)
        for one in counted(wanted, "writing maps", "maps"):
            _optimised(plain[one.name], parts[one.name], one)


def _optimised(plain, path, one):
    """A cloud-optimised copy, with overviews."""
    import rasterio.shutil

    options = {"COMPRESS": "DEFLATE", "PREDICTOR": "NO", "BLOCKSIZE": TILE, "OVERVIEW_RESAMPLING": one.overview,
               "BIGTIFF": "IF_SAFER", "NUM_THREADS": "1"}
    rasterio.shutil.copy(plain, path, driver="COG", **options)
    with rasterio.open(path) as file:
        if file.driver != "GTiff" or not file.width:
            raise OSError("is not whole")
    plain.unlink()


def tiles(grid):
    """[(rows, columns)] of the tiles, first and last + 1."""
    return [((r, min(r + TILE, grid.rows)), (c, min(c + TILE, grid.columns)))
            for r in range(0, grid.rows, TILE) for c in range(0, grid.columns, TILE)]


def tile_of(setting, index, grid, rows, columns):
    """{name: values (rows, columns)} of a tile, None where nothing comes."""
    west, east = grid.west + columns[0] * grid.cell, grid.west + columns[1] * grid.cell
    north, south = grid.north - rows[0] * grid.cell, grid.north - rows[1] * grid.cell
    b = index.bounds
    near = (b[:, 0] < east) & (b[:, 2] > west) & (b[:, 1] < north) & (b[:, 3] > south)
    if not near.any():
        return None
    limits = (0.0, *setting.file.pressures)
    found, probabilities, numbers = {}, {}, {}
    for k, name in enumerate(index.names):
        own = np.flatnonzero(near & (index.scenario == k))
        peaks, releases, survives, numbers[name] = _scenario(setting, index, grid, own, rows, columns, limits)
        probabilities[name] = 1.0 - survives
        reached = releases > 0
        for kind, values in zip(MAPPED, peaks, strict=True):
            found[f"{kind}_{name}"] = np.where(reached, values, NO_DATA).astype(np.float32)
        classes = 1 + np.digitize(peaks[MAPPED.index("peak_pressure")], setting.file.pressures)
        found[f"intensity_{name}"] = np.where(reached, classes, 0).astype(np.uint8)
        found[f"releases_{name}"] = np.where(reached, releases, NO_DATA).astype(np.float32)
        found[f"probability_{name}"] = np.where(reached, probabilities[name][0], NO_DATA).astype(np.float32)
    by_period = sorted(index.names, key=lambda name: setting.file.scenarios[name].period)
    periods = [setting.file.scenarios[name].period for name in by_period]
    total = frequency_of(periods, [probabilities[name] for name in by_period], lambda a, b: 1.0 - (1.0 - a) * (1.0 - b))
    arrivals = frequency_of(periods, [numbers[name] for name in by_period], np.add)
    found["arrivals"] = np.where(arrivals > 0.0, arrivals, NO_DATA).astype(np.float32)
    for (key, _), values in zip(_frequencies(setting), total, strict=True):
        found[key] = np.where(values > 0.0, values, NO_DATA).astype(np.float32)
    if setting.file.zones:
        peaks = [np.where(found[f"releases_{name}"] > 0.0, found[f"peak_pressure_{name}"], np.nan)
                 for name in by_period]
        found[ZONE] = zones_of(setting.file.zones, periods, peaks, arrivals)
    return found


def frequency_of(periods, shares, join):
    """Frequency [1/year] of scenarios by growing return period [years]; join: two of one period."""
    found, held, k = np.zeros_like(shares[0]), np.zeros_like(shares[0]), 0
    while k < len(periods):
        same, own = periods[k], shares[k]
        while k + 1 < len(periods) and periods[k + 1] == same:
            k += 1
            own = join(own, shares[k])
        k += 1
        held = np.maximum(held, own)
        found += held * (1.0 / same - (1.0 / periods[k] if k < len(periods) else 0.0))
    return found


def _scenario(setting, index, grid, own, rows, columns, limits):
    """(peaks (3, rows, columns), number of releases, probability that none comes (limits, rows, columns), expected
    number that comes) of runs."""
    shape = rows[1] - rows[0], columns[1] - columns[0]
    peaks, releases = np.zeros((len(MAPPED), *shape)), np.zeros(shape, np.int32)
    survives, expected = np.ones((len(limits), *shape)), np.zeros(shape)
    for area in np.unique(index.area[own]):
        runs = own[index.area[own] == area]
        hits = np.zeros((len(limits), *shape), np.int32)
        for k in runs:
            placed = _placed(setting, index, grid, k, rows, columns)
            if placed is None:
                continue
            window, values = placed
            reached = values[0] >= max(float(index.flow_depth[k]), 1e-6)
            peak = peaks[(slice(None), *window)]
            np.maximum(peak, np.where(reached, values, 0.0), out=peak)
            for n, limit in enumerate(limits):
                hits[(n, *window)] += reached & (values[2] >= limit)
        releases += hits[0] > 0
        share = hits / int(index.samples[runs].max())
        survives *= 1.0 - share
        expected += share[0]
    return peaks, releases, survives, expected


def _placed(setting, index, grid, k, rows, columns):
    """(slices of the tile, values (3, ...) of a run in it, rows from the north); None where it is beside."""
    maps = untrusted.maps(plan.results_of(setting.folder, index.name_of(k)) / RUN_MAPS, MAPPED)
    values = np.stack([np.nan_to_num(maps[name])[::-1] for name in MAPPED])
    first = round((grid.north - (float(maps["corner"][1]) + grid.cell * values.shape[1])) / grid.cell) - rows[0]
    left = round((float(maps["corner"][0]) - grid.west) / grid.cell) - columns[0]
    top, begin = max(first, 0), max(left, 0)
    last = min(first + values.shape[1], rows[1] - rows[0])
    end = min(left + values.shape[2], columns[1] - columns[0])
    if top >= last or begin >= end:
        return None
    return (slice(top, last), slice(begin, end)), values[:, top - first : last - first, begin - left : end - left]


class _Store:
    """The same maps as a Zarr store over scenario, y and x, a chunk a tile."""

    def __init__(self, setting, grid, wanted, path):
        import zarr

        self._scenarios = list(setting.file.scenarios)
        self._arrays, attributes = {}, {"crs": setting.wkt or "", "cell": grid.cell, "scenarios": self._scenarios}
        group = zarr.create_group(str(path), overwrite=True, attributes=attributes)
        for one in wanted:
            key = self._key(one)
            if key in self._arrays:
                continue
            many = one.scenario is not None
            shape, chunks = (grid.rows, grid.columns), (min(TILE, grid.rows), min(TILE, grid.columns))
            names = ("y", "x")
            if many:
                shape, chunks, names = (len(self._scenarios), *shape), (1, *chunks), ("scenario", *names)
            # 0 where nothing comes: xarray and others know no other way to say so that all of their versions read
            self._arrays[key] = group.create_array(
                key, shape=shape, chunks=chunks, dtype=one.kind, fill_value=0, dimension_names=names,
                attributes={"units": one.unit, "meaning": "0 where nothing comes"})
        periods = [setting.file.scenarios[name].period for name in self._scenarios]
        for name, dimension, values, unit in (
                ("x", "x", grid.west + grid.cell * (np.arange(grid.columns) + 0.5), "m"),
                ("y", "y", grid.north - grid.cell * (np.arange(grid.rows) + 0.5), "m"),
                ("period", "scenario", np.array(periods), "years")):
            axis = group.create_array(name, shape=values.shape, dtype="float64", dimension_names=(dimension,),
                                      attributes={"units": unit})
            axis[:] = values
        self._path = str(path)
        self._wanted = {one.name: one for one in wanted}

    @staticmethod
    def _key(one):
        return one.name.removesuffix(f"_{one.scenario}") if one.scenario else one.name

    def put(self, rows, columns, found):
        """Write a tile."""
        for name, values in found.items():
            one = self._wanted[name]
            where = np.s_[rows[0] : rows[1], columns[0] : columns[1]]
            if one.scenario is not None:
                where = (self._scenarios.index(one.scenario), *where)
            self._arrays[self._key(one)][where] = np.where(values == NO_DATA, 0, values)

    def close(self):
        """Put what is known of all arrays into one place, which is faster to open."""
        import zarr

        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # that consolidated metadata are no part of the format yet
            zarr.consolidate_metadata(self._path)
