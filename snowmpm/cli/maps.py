"""`snowmpm maps`: maps and numbers of an avalanche."""

import sys
import warnings
from enum import Enum
from pathlib import Path
from typing import Annotated

import typer

from snowmpm import overwriting
from snowmpm.cli.options import Quiet, RunPath
from snowmpm.cli.table import print_definitions, print_facts
from snowmpm.errors import InputError
from snowmpm.stages import counted


def _definitions(wanted: bool):
    if wanted:
        from snowmpm.quantities.saw import SAW_TEST
        from snowmpm.quantities.table import (
            GAUGES,
            HISTORY,
            IMPACT,
            NUMBERS,
            OVER_TIME,
            PASSED,
            PATH,
            POWDER_LAYER,
            RASTERS,
        )

        print_definitions({"maps": RASTERS, "maps over time": OVER_TIME, "numbers": NUMBERS,
                           "gauges": (*GAUGES, *PASSED), "along a path": PATH, "impact": IMPACT, "history": HISTORY,
                           "powder layer": POWDER_LAYER, "saw test": SAW_TEST})
        raise typer.Exit


class Files(str, Enum):
    """What `maps` writes."""

    all = "all"
    gis = "gis"
    pictures = "pictures"


KINDS = ("mp4", "gif")
SHADE = "hillshade.tif"
MOST_CELLS = 4e6
"""Of the shaded ground."""
GAUGES = ("gauges.csv", "gauge_profiles.csv", "gauges.png")
FIXED = (SHADE, "avalanche.gpkg", "avalanche.geojson", "avalanche.qgs", "avalanche.csv", "areas.csv",
         "avalanche.json", "before_after.png", "thalweg.png", "thalweg_time.png", *GAUGES)
"""Files beside those named after a map."""
Folder = Annotated[Path | None, typer.Option("-o", "--output", metavar="DIR", help="Folder; RUN/maps by default.")]
FilesOption = Annotated[
    Files, typer.Option("--files", help="gis: for QGIS and others, and tables; pictures: needs no gis extra."),
]
Pictures = Annotated[bool, typer.Option("--pictures", hidden=True, help="As --files pictures.")]
ObservedFile = Annotated[
    Path | None,
    typer.Option("--observed", metavar="FILE", help="Outline of an observed avalanche (.shp, .geojson, .gpkg, a raster"
                                                    " above 0, or event:NAME): drawn beside the computed one, with"
                                                    " scores."),
]
OverTime = Annotated[
    str | None,
    typer.Option("--over-time", metavar="KIND", help="Also flow depth and speed over time: films of the map, mp4 or"
                                                     " gif, and layers for the time slider of QGIS."),
]
GaugesFile = Annotated[
    Path | None,
    typer.Option("--gauges", metavar="FILE", help="Lines and points (.shp, .geojson or .gpkg): depth, speed, pressure"
                                                  " over time on each, discharge and volume across lines."),
]
PathFile = Annotated[
    Path | None,
    typer.Option("--path", metavar="FILE", help="A line (.shp, .geojson or .gpkg): run-out, fall and maxima along it,"
                                                " as AvaFrame's AIMEC has them; along the thalweg without it."),
]
Definitions = Annotated[
    bool, typer.Option("--definitions", callback=_definitions, is_eager=True, help="Say what each number means.")
]


def maps(run: RunPath, output: Folder = None, files: FilesOption = Files.all, observed: ObservedFile = None,
         gauges: GaugesFile = None, path: PathFile = None, over_time: OverTime = None, quiet: Quiet = False,
         pictures: Pictures = False, definitions: Definitions = False):
    """Draw the maps of an avalanche, and print its run-out.

    Peak depth, speed, pressure and momentum, arrival time, duration, deposit and release: each as a GeoTIFF in the
    projection of the elevation raster, with a QGIS style, and as a picture over the shaded terrain. Outlines by
    pressure class, release, thalweg and run-out as GeoPackage and, where the terrain has a projection, GeoJSON; numbers
    and areas by class as CSV and JSON; a QGIS project that opens everything over the shaded terrain, with a print
    layout; plots along the thalweg, of the peaks and over time; the depth before and after on one sheet. Each file says
    whether the run is final: complete, at rest, without loss of mass.
    """
    if pictures:
        print("warning: --pictures is now --files pictures", file=sys.stderr)
        files = Files.pictures
    pictures, gis_only = files == Files.pictures, files == Files.gis
    from snowmpm.cli.info import print_avalanche
    from snowmpm.io import Run

    opened = Run(run)
    if not opened.maps:
        raise InputError(f"{opened.path}: no maps: they are made of runs in three dimensions, at their end; a run that"
                         " was killed gets them when --resume has brought it there")
    if over_time not in (None, *KINDS):
        raise InputError.not_in("--over-time", over_time, KINDS)
    folder = output or opened.path.with_name("maps")
    overwriting.guard_in(folder, _names(opened, over_time))
    if observed is not None and str(observed).startswith("event:"):
        from snowmpm.events.store import outline_file

        observed = outline_file(str(observed).removeprefix("event:"))
    asked = _asked(opened, {"observed": observed, "gauges": gauges, "path": path}, pictures)
    moments = list(_moments(opened, folder)) if over_time and not pictures else []
    written = list(_files(opened, folder, asked, moments)) if asked else []
    written += [] if gis_only else _pictures(opened, folder, asked)
    if asked and asked.gauges:
        written += _of_gauges(asked.gauges, opened, folder, gis_only)
    for left in (folder / name for name in GAUGES if folder / name not in written):
        if left.is_file() and overwriting.is_own(left):  # of an earlier call: no longer those of the other files
            left.unlink()
    if over_time and not gis_only:
        written += _films(opened, folder, over_time)
    for file in () if quiet else written:
        print(file)
    if not quiet and not pictures and not opened.provenance.get("crs"):
        print("no avalanche.geojson: the terrain names no coordinate system, and GeoJSON without one would be read as"
              " longitude and latitude")
    if not quiet:
        print_avalanche(opened)
    if not quiet and asked:
        for one in asked.scores or ():
            print_facts(f"\n{one['outline']} against {asked.outline.name}", _told(one))
        for one in asked.gauges:
            print_facts(f"\n{one.place.name}", _measured(one))
        if path:
            print_facts(f"\nalong {path.name}", _worded(asked.along))


def _names(run, over_time):
    """Names of the files that the command writes."""
    from snowmpm.io.flow_maps import NAMES, moments

    rasters = [f"{name}{ending}" for name in run.maps for ending in (".tif", ".qml", ".png")]
    if not over_time:
        return [*rasters, *FIXED]
    films = [f"{name}.{over_time}" for name in NAMES]
    return [*rasters, *films, *(_moment(name, i) for i, *_ in moments(run) for name in NAMES), *FIXED]


def _moment(name, i):
    return f"over_time/{name}_{i:05d}.tif"


def _asked(run, files, pictures):
    """`snowmpm.gis.asked.Asked` of a run, by files of options; its warnings are printed."""
    given = {name: path for name, path in files.items() if path is not None}
    if pictures:
        if given:
            raise InputError(f"--{next(iter(given))}: not with --files pictures, which are of the run alone")
        return None
    from snowmpm.gis.asked import asked_of

    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always", UserWarning)
        found = asked_of(run, **given)
    for warning in said:
        print(f"warning: {warning.message}")
    return found


def _of_gauges(asked, run, folder, gis_only):
    """Write what flowed past gauges; -> the paths."""
    from snowmpm.gis.lines import write_profiles, write_series

    yield write_series(folder / "gauges.csv", asked)
    if any(one.place.is_line for one in asked):
        yield write_profiles(folder / "gauge_profiles.csv", asked)
    if not gis_only:
        from snowmpm.render.gauge_plot import render_gauges

        yield render_gauges(run, asked, folder / "gauges.png")


def _measured(gauge):
    """Numbers of a gauge as text."""
    if gauge.numbers["gauge_arrival"] is None:
        return {"arrival": "the flow did not come here"}
    return _worded(gauge.numbers)


def _worded(numbers):
    from snowmpm.quantities.table import quantity

    return {quantity(name).label: quantity(name).text(value) for name, value in numbers.items()}


def _files(run, folder, asked, moments):
    """Write the files for a GIS; -> their paths. asked: `Asked`; moments: rasters over time that the project shows."""
    from snowmpm import gis
    from snowmpm.io.geotiff import require_rasterio, write_geotiff
    from snowmpm.io.parameters import parameters
    from snowmpm.io.published import statement
    from snowmpm.io.status import status_of
    from snowmpm.quantities.table import quantity

    require_rasterio()
    crs, status = run.provenance.get("crs"), status_of(run)
    tags = {"run": run.name, "statement": statement(run), "status": status.text, "final": status.final,
            **parameters(run)}
    for name, raster in counted(run.maps.items(), "writing GeoTIFFs", "maps"):
        one = quantity(name, raster.units)
        yield write_geotiff(folder / f"{name}.tif", raster, run.origin, crs, f"{one.label} [{raster.units}]",
                            {**tags, "definition": one.definition})
        yield gis.write_style(folder / f"{name}.qml", name, raster)
    shade = _shade(run)
    if shade is not None:
        yield write_geotiff(folder / SHADE, shade, run.origin, crs, "shaded ground, 0 to 254; 255: no ground", tags)
    if "flow_depth" not in run.hazard.get("numbers", {}):
        return
    gis.require_pyogrio()
    layers = gis.layers_of(run, asked.outline)
    if asked.gauges:
        from snowmpm.gis.lines import layers_of_gauges

        layers += layers_of_gauges(run, asked.gauges)
    yield gis.write_geopackage(folder / "avalanche.gpkg", layers, crs, gis.vector_style)
    if crs:
        yield gis.write_geojson(folder / "avalanche.geojson", layers, crs)
    yield gis.write_project(folder / "avalanche.qgs", run, layers, "avalanche.gpkg", moments, shade is not None)
    yield gis.write_numbers(folder / "avalanche.csv", run, asked)
    yield gis.write_areas(folder / "areas.csv", run)
    yield gis.write_record(folder / "avalanche.json", run, asked)


def _shade(run):
    """`Map` of the shaded ground under the maps, 0 to 254, as fine as the ground is known; None without a ground.

    A shade that QGIS computes has seams, where the tiles meet that it draws."""
    import numpy as np

    from snowmpm.io.ground_maps import Map
    from snowmpm.render import light
    from snowmpm.render.relief import height_raster, map_shade

    place, terrain = next(iter(run.maps.values())), run.terrain
    if terrain is None or terrain.facets.shape[1] != 3:
        return None
    extent = np.ptp(terrain.vertices[:, :2], axis=0)
    known = np.sqrt(2.0 * float(extent.prod()) / len(terrain.facets))
    finest = np.sqrt(MOST_CELLS / place.values.size)
    parts = int(max(1.0, min(round(place.cell / known), finest, 16.0)))
    cell = place.cell / parts
    corner = np.array([place.x0, place.y0]) - 0.5 * place.cell + 0.5 * cell
    shape = tuple(parts * n for n in place.values.shape[::-1])
    heights = height_raster(terrain.vertices.astype(float), terrain.facets, corner, cell, shape)
    if heights is None:
        return None
    values = np.full(heights.shape, 255.0)  # no ground: no gap, at which smooth drawing would turn black
    shade = map_shade(heights, cell)
    known = np.isfinite(shade)
    values[known] = np.minimum(light.encode(np.repeat(shade[known][:, None], 3, axis=-1))[:, 0], 254)
    return Map(values, *map(float, corner), cell, "1")


def _pictures(run, folder, asked):
    """Draw the pictures; -> their paths."""
    from snowmpm.render import render_thalweg, render_thalweg_time
    from snowmpm.render.peak_map import MapSheet

    seen = asked.outline if asked else None
    sheet = MapSheet(run, seen.rings if seen else None, places=asked.places if asked else ())
    drawn = {name for name, raster in run.maps.items() if (raster.values > 0.0).any()}
    for name in counted(run.maps, "drawing maps", "maps"):
        if name in drawn:
            yield sheet.render(name, folder / f"{name}.png")
    if {"release_depth", "deposit_depth"} <= drawn:
        yield sheet.before_after(folder / "before_after.png")
    if run.hazard.get("profile"):
        yield render_thalweg(run, folder / "thalweg.png")
        if "velocity" in run.field_names:
            yield render_thalweg_time(run, folder / "thalweg_time.png")


def _moments(run, folder):
    """Write rasters over time as GeoTIFFs; yields `gis.Moment`s."""
    from snowmpm import gis
    from snowmpm.io.flow_maps import NAMES, FlowMaps, moments
    from snowmpm.io.geotiff import require_rasterio, write_geotiff
    from snowmpm.io.ground_maps import Map
    from snowmpm.quantities.table import quantity

    require_rasterio()
    times, crs = moments(run), run.provenance.get("crs")
    place, found = run.maps["peak_depth"], FlowMaps(run)
    for i, begin, end in counted(times, "writing GeoTIFFs over time", "times"):
        values = found.at(i)
        for name in NAMES:
            one, file = quantity(name), _moment(name, i)
            raster = Map(values[name], place.x0, place.y0, place.cell, one.unit)
            write_geotiff(folder / file, raster, run.origin, crs, f"{one.label} [{one.unit}] at t = {begin:g} s",
                          {"run": run.name, "time": begin, "definition": one.definition})
            yield gis.Moment(name, f"{one.label} over time", file, raster, begin, end)


def _films(run, folder, kind):
    """Draw the map over time; -> the paths of the films."""
    from snowmpm.io.flow_maps import NAMES
    from snowmpm.render import render_map_film

    for name in counted(NAMES, "drawing maps over time", "films"):
        yield render_map_film(run, name, folder / f"{name}.{kind}")


def _told(score):
    """Scores as text with units."""
    from snowmpm.quantities.quantity import written

    units = {"area": "m2", "index": "share", "rate": "share", "ratio": "share", "reach": "m", "difference": "m"}
    return {name: written(value, "1" if name == "area_ratio" else units[name.rpartition("_")[2]])
            for name, value in score.items() if name != "outline"}
