"""`snowmpm maps`: maps and numbers of an avalanche."""

from pathlib import Path
from typing import Annotated

import typer

from snowmpm.cli.options import RunPath
from snowmpm.errors import InputError

Folder = Annotated[Path | None, typer.Option("-o", "--output", metavar="DIR", help="Folder; RUN/maps by default.")]
Pictures = Annotated[bool, typer.Option("--pictures", help="Pictures only, no GeoTIFF.")]


def maps(run: RunPath, output: Folder = None, pictures: Pictures = False):
    """Draw the maps of an avalanche, and say how far it came.

    Peak depth, speed and pressure, deposit and release, each as a GeoTIFF in the projection of the elevation raster and
    as a picture over the shaded terrain; a plot along the thalweg; run-out, affected area, deposit.
    """
    from snowmpm.cli.info import print_avalanche
    from snowmpm.io import Run
    from snowmpm.io.geotiff import require_rasterio, write_geotiff
    from snowmpm.render import render_map, render_thalweg

    opened = Run(run)
    if not opened.maps:
        raise InputError(f"{opened.path}: no maps: they are made of runs in three dimensions, at their end")
    folder = output or opened.path.with_name("maps")
    if not pictures:
        require_rasterio()
    folder.mkdir(parents=True, exist_ok=True)
    for name, raster in opened.maps.items():
        if not pictures:
            words = f"{name} [{raster.units}]".replace("_", " ")
            print(write_geotiff(folder / f"{name}.tif", raster, opened.origin, opened.provenance.get("crs"), words))
        if (raster.values > 0.0).any():
            print(render_map(opened, name, folder / f"{name}.png"))
    if opened.hazard.get("profile"):
        print(render_thalweg(opened, folder / "thalweg.png"))
    print_avalanche(opened)
