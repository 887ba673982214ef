"""The page of a region: maps/index.html, which opens in a browser without a server.

Pictures of 256 x 256 pixels lie beside it, by layer, level and place, so that the page shows any size of region. A
picture without anything to show is not written.
"""

import csv
import html
import json
import math
import shutil
import warnings
from dataclasses import dataclass
from datetime import date
from pathlib import Path

import numpy as np
import shapely

from snowmpm import __version__
from snowmpm.draft import draft, write_text
from snowmpm.io.projection import projection_name
from snowmpm.quantities.classes import PRESSURE
from snowmpm.region import exposure, launch, plan
from snowmpm.region.elevations import CACHE
from snowmpm.region.outlines import class_names
from snowmpm.region.zones import ZONES
from snowmpm.stages import counted

FILE, PICTURES = "index.html", "page"
SIDE = 256
"""Of a picture [pixels]."""
SUN = math.radians(315.0), math.radians(45.0)
"""Azimuth and height of the light on the ground."""
FREQUENT = tuple((1.0 - 1e-4) / years for years in (300.0, 100.0, 30.0, 10.0))
"""Frequencies [1/year] from which on the next colour holds; the usual return periods belong to it, whatever round-off
says."""
FREQUENT_COLOURS = ("#cfe1f2", "#93c4df", "#4b97c9", "#1764ab", "#08306b")
AREAS = "#7a1fa2"
MOST_ROWS = 200
"""Of the table of what is exposed."""
TEMPLATE = Path(__file__).with_name("page.html")


@dataclass(frozen=True)
class Shown:
    """A layer of the page: key, title, legend [(colour, words)], whether it is on at first."""

    key: str
    title: str
    legend: list
    on: bool


def write(setting, index, folder):
    """Write the page and its pictures; -> its path."""
    import rasterio

    pictures = Path(folder) / PICTURES
    shutil.rmtree(pictures, ignore_errors=True)
    shown = _layers(setting)
    with warnings.catch_warnings(), rasterio.Env(GDAL_CACHEMAX=CACHE):
        warnings.simplefilter("ignore")
        with rasterio.open(next(Path(folder).glob("intensity_*.tif"))) as file:
            height, width = file.shape
            transform = file.transform
        levels = max(0, math.ceil(math.log2(max(height, width, SIDE) / SIDE)))
        for layer in counted(shown, "drawing the page", "layers"):
            _draw(layer, setting, Path(folder), pictures / layer.key, (height, width), transform, levels)
    facts = {"side": SIDE, "levels": levels, "width": width, "height": height, "cell": transform.a,
             "west": transform.c, "north": transform.f,
             "layers": [{"key": one.key, "title": one.title, "on": one.on, "legend": one.legend} for one in shown]}
    text = TEMPLATE.read_text(encoding="utf-8")
    for mark, value in (("FACTS", json.dumps(facts).replace("</", "<\\/")), ("TITLE", html.escape(setting.file.name)),
                        ("ABOUT", _about(setting, index)), ("EXPOSED", _exposed(Path(folder) / exposure.TABLE))):
        text = text.replace(f"@@{mark}@@", value)
    return write_text(Path(folder) / FILE, text)


def _layers(setting):
    """List of `Shown`, the lowest first."""
    names, pressures = class_names(setting.file.pressures), len(setting.file.pressures)
    colours = PRESSURE.colours[: pressures + 1]
    found = [Shown("ground", "Terrain", [], True)]
    found.append(Shown("frequency", "Frequency", [[colour, words] for colour, words in zip(FREQUENT_COLOURS, (
        "less than once in 300 years", "once in 300 years or more", "once in 100 years or more",
        "once in 30 years or more", "once in 10 years or more"), strict=True)], False))
    if setting.file.zones:
        zoning = ZONES[setting.file.zones]
        found.append(Shown("zones", f"Zones, {setting.file.zones}", [
            [colour, words] for colour, words in zip(zoning.colours, zoning.names, strict=True)], False))
    by_period = sorted(setting.file.scenarios, key=lambda name: setting.file.scenarios[name].period)
    for name in reversed(by_period):
        years = f"{setting.file.scenarios[name].period:g} years"
        found.append(Shown(f"intensity_{name}", f"Peak pressure, {years} ({name})",
                           [[colour, names[k + 1][0]] for k, colour in enumerate(colours)], name == by_period[-1]))
    for name in by_period:
        found.append(Shown(f"areas_{name}", f"Release areas, {setting.file.scenarios[name].period:g} years ({name})",
                           [[AREAS, "release area"]], False))
    return found


def _draw(layer, setting, folder, target, shape, transform, levels):
    """Write the pictures of a layer at all levels; level 0 is the coarsest."""
    import rasterio
    from PIL import Image

    areas = _tree(setting, layer.key.removeprefix("areas_")) if layer.key.startswith("areas_") else None
    source = setting.terrain if layer.key == "ground" else folder / f"{layer.key}.tif"
    file = None if areas is not None else rasterio.open(source)
    try:
        for level in range(levels + 1):
            step = 2 ** (levels - level)
            for row in range(math.ceil(shape[0] / step / SIDE)):
                for column in range(math.ceil(shape[1] / step / SIDE)):
                    box = _box(transform, row, column, step)
                    picture = (_of_areas(areas, box) if areas is not None else _shaded(file, box)
                               if layer.key == "ground" else _coloured(file, box, layer))
                    if picture is None:
                        continue
                    with draft(target / f"{level}_{column}_{row}.png") as part:
                        if picture.shape[-1] == 2:
                            Image.fromarray(picture, "LA").save(part, "PNG", optimize=True)
                        else:
                            Image.fromarray(picture, "RGBA").quantize(32).save(part, "PNG", optimize=True)
    finally:
        if file is not None:
            file.close()


def _box(transform, row, column, step):
    """west, south, east, north [m] of a picture."""
    side = SIDE * step * transform.a
    west, north = transform.c + column * side, transform.f - row * side
    return west, north - side, west + side, north


def _read(file, box, resampling, around=0):
    """Pixels of a box and `around` it."""
    from rasterio.windows import from_bounds

    wide = around * (box[2] - box[0]) / SIDE
    window = from_bounds(box[0] - wide, box[1] - wide, box[2] + wide, box[3] + wide, transform=file.transform)
    return file.read(1, window=window, out_shape=(SIDE + 2 * around,) * 2, boundless=True, masked=True,
                     resampling=resampling)


def _shaded(file, box):
    """The ground under a low sun, grey and opacity (SIDE, SIDE, 2); None where there is none."""
    from rasterio.enums import Resampling

    z = _read(file, box, Resampling.average, 1).astype(float)
    if np.ma.getmaskarray(z).all():
        return None
    z = z.filled(np.nan)
    cell = (box[2] - box[0]) / SIDE
    north, east = np.gradient(z, cell)
    north = -north
    steep = np.sqrt(1.0 + east**2 + north**2)
    light = (math.sin(SUN[1]) - math.cos(SUN[1]) * (east * math.sin(SUN[0]) + north * math.cos(SUN[0]))) / steep
    grey = np.nan_to_num(np.clip(70.0 + 180.0 * light, 0.0, 255.0))
    return np.dstack([grey, np.where(np.isfinite(light), 255.0, 0.0)])[1:-1, 1:-1].astype(np.uint8)


def _coloured(file, box, layer):
    """Colours of the classes of a map (SIDE, SIDE, 4); None where there is nothing."""
    from rasterio.enums import Resampling

    values = _read(file, box, Resampling.nearest)
    there = ~np.ma.getmaskarray(values) & (values.data > 0)
    if not there.any():
        return None
    number = np.digitize(values.data, FREQUENT) if layer.key == "frequency" else values.data.astype(int) - 1
    palette = np.array([_rgb(colour) for colour, _ in layer.legend], np.uint8)
    found = np.zeros((SIDE, SIDE, 4), np.uint8)
    found[there, :3] = palette[np.clip(number[there], 0, len(palette) - 1)]
    found[there, 3] = 190
    return found


def _tree(setting, scenario):
    return shapely.STRtree([one.geometry for one in plan.read_areas(setting.folder, scenario)])


def _of_areas(tree, box):
    """Outlines of release areas (SIDE, SIDE, 4); None where there are none."""
    from rasterio.features import rasterize
    from rasterio.transform import from_bounds

    near = tree.geometries[tree.query(shapely.box(*box))]
    if not len(near):
        return None
    transform = from_bounds(*box, SIDE, SIDE)
    inside = rasterize([(one, 1) for one in near], (SIDE, SIDE), transform=transform, dtype="uint8")
    line = rasterize([(one.boundary, 1) for one in near], (SIDE, SIDE), transform=transform, all_touched=True,
                     dtype="uint8")
    found = np.zeros((SIDE, SIDE, 4), np.uint8)
    found[(inside > 0) | (line > 0)] = (*_rgb(AREAS), 70)
    found[line > 0] = (*_rgb(AREAS), 255)
    return found


def _rgb(text):
    return tuple(int(text[k : k + 2], 16) for k in (1, 3, 5))


def _about(setting, index):
    """Paragraphs about the region, as HTML."""
    friction = (f"friction {setting.file.friction.card}" if setting.file.friction.card else
                f"friction by {len(setting.file.friction.classes)} classes of terrain")
    runs = setting.file.samples.runs
    lines = list(launch.told(setting, index))
    snow = "; ".join(f"{name}: {one.period:g} years, {_thickness(one)}" for name, one in setting.file.scenarios.items())
    forest = setting.file.forest
    said = [*(line for line, warns in lines if not warns), snow,
            f"depth-averaged flow on cells of {setting.cell:g} m, {friction}, {runs} run{'s' * (runs > 1)} a release",
            f"density {setting.file.flow.density:g} kg/m3; routing at {setting.file.flow.reach:g} degrees; "
            + ("no forest" if forest is None else "forest protects from releases" if forest.protects
               else "forest does not protect from releases"),
            "Frequency: of being reached at least once a year, all releases of a return period taken for one event, a"
            " lower bound; arrivals.tif is the upper one.",
            f"Coordinates: {projection_name(setting.wkt) or 'no coordinate system known'}. snowmpm {__version__},"
            f" {date.today():%d %B %Y}.",
            "A hazard indication map: it does not replace the judgement of an expert on site."]
    if setting.file.attribution:
        said.append(f"Terrain: {setting.file.attribution}")
    warned = "".join(f'<p class="warning">{html.escape(line)}</p>' for line, warns in lines if warns)
    return warned + "".join(f"<p>{html.escape(line)}</p>" for line in said)


def _thickness(scenario):
    """The thickness of a scenario in words."""
    given = scenario.thickness
    if given is None:
        return "thickness of the file of release areas"
    if given.value is not None:
        return f"{given.value:g} m thick"
    if given.file is not None:
        return "thickness by a raster"
    return f"{given.three_day_snow:g} m of snow in three days at {given.reference_altitude:g} m"


def _exposed(path):
    """The first rows of the table of what is exposed, as HTML."""
    if not path.is_file():
        return "<p>No layers were given as <code>exposed</code>.</p>"
    with path.open(encoding="utf-8", newline="") as file:
        rows = list(csv.reader(file))
    place = rows[0].index("class")
    reached = [row for row in rows[1:] if row[place] not in ("", "0")]
    unknown = sum(row[place] == "" for row in rows[1:])
    others = len(rows) - 1 - len(reached) - unknown
    rows = [rows[0], *reached[:MOST_ROWS]]
    head = "".join(f"<th>{html.escape(one.replace('_', ' '))}</th>" for one in rows[0])
    body = "".join("<tr>" + "".join(f"<td>{html.escape(one)}</td>" for one in row) + "</tr>" for row in rows[1:])
    said = [f"{len(reached) - MOST_ROWS} more are reached" if len(reached) > MOST_ROWS else "",
            f"{others} are not reached", f"of {unknown}, outside of the map or the area of interest, nobody knows"
            if unknown else ""]
    return f"<table><tr>{head}</tr>{body}</table><p>{'; '.join(filter(None, said))} ({exposure.TABLE}).</p>"
