"""`snowmpm chain`: from a snow pit to hazard maps, in one command."""

import math
from pathlib import Path
from typing import Annotated

import typer

from snowmpm import overwriting
from snowmpm.cli.options import Backend, Json, Quiet, Threads
from snowmpm.cli.profile import LayerAt, Modulus, Time
from snowmpm.cli.table import print_json
from snowmpm.errors import InputError


def chain(
    pit: Annotated[Path, typer.Argument(metavar="PIT", help="A snow profile, as `snowmpm profile` reads it.")],
    terrain: Annotated[Path, typer.Option(metavar="FILE", help="Elevation raster (.asc, .tif), in metres.")],
    at: Annotated[str, typer.Option(metavar="X,Y", help="Where the slab is, in the coordinates of the raster.")],
    output: Annotated[
        Path | None, typer.Option("-o", "--output", metavar="DIR", help="Folder; runs/PIT_chain by default.")
    ] = None,
    layer: LayerAt = None,
    size: Annotated[
        float | None,
        typer.Option(metavar="M", help="Side of the square of weak layer; 28 thicknesses of the slab by default."),
    ] = None,
    modulus: Modulus = "bergfeld",
    time: Time = None,
    threads: Threads = None,
    quiet: Quiet = False,
    as_json: Json = False,
):
    """From a snow pit to hazard maps: profile, stability, release on the local slope, flow, maps.

    The slab lies on a square of its weak layer around X,Y, is cut by a saw, and tears off if the slope and its strength
    let it; what went is the release of a depth-averaged flow. report.html shows every assumption with its source, and
    what the result depends on most: the flow is computed with other frictions, thicknesses and areas of the release.
    """
    import sys

    from snowmpm import gis
    from snowmpm.cli.maps import Files
    from snowmpm.cli.maps import maps as write_maps
    from snowmpm.cli.profile import chosen
    from snowmpm.cli.run import start_taichi
    from snowmpm.io.geotiff import require_rasterio
    from snowmpm.pit import chain as steps
    from snowmpm.pit.chain_report import write_report
    from snowmpm.pit.mechanics import MODULI
    from snowmpm.pit.reader import read_profile
    from snowmpm.pit.weak_layers import candidates
    from snowmpm.render.pit_plot import render_pit

    if modulus not in MODULI:
        raise InputError.not_in("--modulus", modulus, MODULI)
    if size is not None and not 2.0 <= size <= steps.LONGEST:
        raise InputError.at("--size", size, f"must be from 2 to {steps.LONGEST:g} m")
    place = _place(at)
    overwriting.reads(pit)
    overwriting.reads(terrain)
    read = read_profile(pit, time)
    found = candidates(read)
    folder = output or Path("runs") / f"{pit.stem}_chain"
    overwriting.guard_in(folder, steps.NAMES)
    for name in steps.FOLDERS:
        if (folder / name).is_symlink():
            raise InputError(f"{folder / name}: a link to elsewhere: nothing is written there")
    gis.require_pyogrio()  # of the release and the maps: not after a minute of computing
    require_rasterio()
    start_taichi(Backend.cpu, threads)

    def say(text):
        if not quiet:
            print(text, file=sys.stderr, flush=True)

    index, fails = chosen(read, found, layer)
    done = steps.begin(read, found, index, terrain, place, folder, modulus, size, fails)
    picture = render_pit(read, folder / "profile.png", weak=done.index)
    steps.release_of(done, say)
    if done.released is not None:
        steps.flow_of(done, say)
        say("maps")
        write_maps(folder / "flow", folder / "maps", Files.all, quiet=True)
    written = [picture, steps.write_numbers(done), *write_report(done, picture)]
    if as_json:
        print_json(steps.record_of(done))
        return
    for path in () if quiet else written:
        print(path)
    if not quiet:
        for line in _told(done):
            print(line)


def _place(text):
    try:
        x, y = map(float, text.split(","))
    except ValueError:
        x = y = math.nan
    if not (math.isfinite(x) and math.isfinite(y)):
        raise InputError.at("--at", text, "must be X,Y, as 600180,200260")
    return x, y


def _told(done):
    if done.why:
        yield f"the slab did not go: {done.why}; no flow was computed"
        return
    release, numbers = done.released, done.base
    yield from (f"warning: {text}" for text in done.notes)
    yield (f"release of the assumed square: {release.area:.0f} m2, {release.thickness:.2f} m thick,"
           f" {release.volume:.0f} m3, on {done.slope.angle:.0f} degrees")
    if numbers.get("runout") is not None:
        yield f"run-out: {numbers['runout']:.0f} m; largest speed {numbers['largest_flow_speed']:.0f} m/s"
    yield from done.dependence()
