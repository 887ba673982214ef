"""`snowmpm runout`: how far an avalanche goes by models that need no flow."""

import sys
from pathlib import Path
from typing import Annotated

import typer

from snowmpm import overwriting
from snowmpm.cli.options import Backend, Json, Quiet, SceneName, Settings, Threads, scene_overrides
from snowmpm.cli.table import print_json
from snowmpm.errors import InputError

PathFile = Annotated[
    Path | None,
    typer.Option("--path", metavar="FILE", help="A line (.shp, .geojson or .gpkg) from the release to beyond the"
                                                " run-out; the way of most snow by default."),
]


def runout(
    scene: SceneName,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", metavar="DIR", help="Folder; runs/SCENE_runout by default.")
    ] = None,
    settings: Settings = None,
    path: PathFile = None,
    calibration: Annotated[
        str, typer.Option(metavar="NAME", help="Of alpha-beta: austria, austria_small or norway.")
    ] = "austria",
    split: Annotated[
        float | None,
        typer.Option(metavar="M", help="Length from which on the beta point is looked for; where the path becomes"
                                       " gentle by default."),
    ] = None,
    angle: Annotated[float, typer.Option(metavar="DEG", help="Of the energy line and of routing.")] = 25.0,
    exponent: Annotated[
        float, typer.Option(metavar="E", help="Of spreading in routing: 1 wide, 75 only where it is steepest.")
    ] = 8.0,
    threads: Threads = None,
    quiet: Quiet = False,
    as_json: Json = False,
):
    """Tell how far an avalanche goes by models that need no flow: alpha-beta, energy line, a block, routing.

    Of a depth-averaged scene: its terrain, its release and its friction. Alpha-beta is statistics of the path, with its
    deviation; the energy line falls at one angle; a block slides with Coulomb's or Voellmy's friction; routing spreads
    over the raster. Writes tables, the path with all run-outs (runout.gpkg), a picture, and rasters of the routing.
    """
    from snowmpm.cli.run import start_taichi
    from snowmpm.cores import available_cores
    from snowmpm.runout.alpha_beta import CALIBRATIONS
    from snowmpm.runout.files import RASTERS, TABLES
    from snowmpm.runout.ground import ground_of
    from snowmpm.runout.models import runout as compute
    from snowmpm.runout.routing import Routing
    from snowmpm.scenes import load_scene

    if calibration not in CALIBRATIONS:
        raise InputError.not_in("--calibration", calibration, CALIBRATIONS)
    for name, value, low, high in (("--angle", angle, 5.0, 60.0), ("--exponent", exponent, 1.0, 100.0),
                                   ("--split", split or 0.0, 0.0, 1e5)):
        if not low <= value <= high:
            raise InputError.at(name, value, f"must be from {low:g} to {high:g}")
    loaded = load_scene(scene, scene_overrides(settings))
    folder = output or Path("runs") / f"{loaded.name}_runout"
    overwriting.guard_in(folder, (*TABLES, *(f"{name}.tif" for name in RASTERS)))
    start_taichi(Backend.cpu, threads)
    ground = ground_of(loaded)
    line, where = _line(path, ground), f"--path = {str(path)!r}"
    if line is None and str(scene).startswith("event:"):
        line, where = _path_of_event(str(scene), ground), f"{scene}: observed.path"
    found = compute(ground, line, where, calibration, split, Routing(angle, exponent), threads or available_cores())
    written = list(_write(found, ground, folder, loaded.name))
    if as_json:
        print_json({**_record(found), "path": where if found.given else None, "calibration": calibration,
                    "split": split, "angle": angle, "exponent": exponent, "thickness": ground.thickness})
        return
    for one in () if quiet else written:
        print(one)
    if not quiet:
        for text in _told(found, calibration, where):
            print(text)


def _path_of_event(scene, ground):
    """The path of an observed avalanche, as far as the ground is known; None where it has none."""
    import numpy as np

    from snowmpm.events import store
    from snowmpm.runout.models import on_ground

    line = store.event(scene.removeprefix(store.PREFIX)).observed.path
    line = on_ground(ground, np.array(line)) if line else ()
    return line if len(line) > 1 else None


def _line(path, ground):
    if path is None:
        return None
    from snowmpm.gis.lines import the_line
    from snowmpm.terrain.reference_system import ReferenceSystem

    overwriting.reads(path)
    return the_line(path, ReferenceSystem.of_text(ground.crs, "the terrain") if ground.crs else None)


def _write(found, ground, folder, name):
    from snowmpm import gis
    from snowmpm.io.geotiff import write_geotiff
    from snowmpm.render.runout_plot import render_runout
    from snowmpm.runout import files

    yield files.write_reaches(folder / "runout.csv", found)
    yield files.write_profile(folder / "profile.csv", found)
    yield render_runout(found, ground, folder / "runout.png", name.replace("_", " "))
    try:
        gis.require_pyogrio()
    except InputError as error:  # the tables and the picture need no extra
        print(f"no runout.gpkg and no rasters: {error}", file=sys.stderr)
        return
    yield gis.write_geopackage(folder / "runout.gpkg", files.layers(found), ground.crs)
    for raster, values in files.rasters(found, ground).items():
        words, unit = files.RASTERS[raster]
        yield write_geotiff(folder / f"{raster}.tif", values, (0.0, 0.0), ground.crs, f"{words} [{unit}]",
                            {"scene": name, "angle": found.routing.angle, "exponent": found.routing.exponent})


def _told(found, calibration, where):
    """The run-outs as a table for reading."""
    rows = [("", "run-out", "angle", "largest speed")]
    for one in found.reaches:
        stop = one.note if one.s is None else f"{one.s:.0f} m" + (f" ({one.note})" if one.note else "")
        rows.append((one.model, stop,
                     "-" if one.angle is None else f"{one.angle:.1f}°",
                     "-" if one.speed is None else f"{one.speed:.1f} m/s"))
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    for row in rows:
        yield "  ".join([row[0].ljust(widths[0]), *map(str.rjust, row[1:], widths[1:])]).rstrip()
    path = where if found.given else "the way of most snow from the top of the release"
    yield f"path: {path}, {found.profile.s[-1]:.0f} m in plan, {found.profile.drop[-1]:.0f} m down"
    if found.statistics:
        yield (f"beta {found.statistics.beta:.1f}° at {found.statistics.beta_s:.0f} m; one avalanche in 6 of the"
               f" statistics ({calibration}) goes beyond alpha - SD, one in 44 beyond alpha - 2 SD")
    for doubt in found.doubts:
        yield f"warning: {doubt}"


def _record(found):
    statistics = found.statistics
    return {
        "path_length": float(found.profile.s[-1]),
        "beta": statistics and statistics.beta, "beta_length": statistics and statistics.beta_s,
        "alpha": statistics and statistics.alpha, "deviation": statistics and statistics.deviation,
        "models": {one.model: {"length": one.s, "angle": one.angle, "speed": one.speed, "note": one.note}
                   for one in found.reaches},
        "doubts": found.doubts,
    }
