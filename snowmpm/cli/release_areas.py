"""`snowmpm release-areas`: where slabs can release on an elevation raster."""

import sys
import tempfile
from pathlib import Path
from typing import Annotated

import typer

from snowmpm import overwriting
from snowmpm.cli.options import Json, Quiet
from snowmpm.cli.table import print_json
from snowmpm.errors import InputError


def release_areas(
    terrain: Annotated[Path, typer.Argument(metavar="TERRAIN", help="Elevation raster (.tif, .asc) in metres.")],
    output: Annotated[
        Path | None, typer.Option("-o", "--output", metavar="FILE", help="GeoPackage; release_areas.gpkg by default.")
    ] = None,
    scenario: Annotated[str, typer.Option(metavar="NAME", help="frequent, rare or extreme.")] = "rare",
    forest: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Polygons, or a raster of crown cover [%].")
    ] = None,
    cover: Annotated[
        float, typer.Option(metavar="PERCENT", help="Crown cover from which trees keep slabs from releasing.")
    ] = 50.0,
    thickness: Annotated[float | None, typer.Option(metavar="M", help="Of all releases, normal to the slope.")] = None,
    three_day_snow: Annotated[
        float | None, typer.Option(metavar="M", help="In place of it: increase of the snow depth in three days at"
                                                     " 2000 m, from which the thickness follows by altitude and slope.")
    ] = None,
    quiet: Quiet = False,
    as_json: Json = False,
):
    """Find potential release areas: steep, even ground, in single basins, as polygons with their attributes.

    Slope, curvature and ruggedness by the bounds of Bühler et al. (2018); neighbouring parts are merged while they face
    the same way. A raster of any size: it is read in tiles. `depth` takes the file as its release.
    """
    from snowmpm.region import release_areas as found
    from snowmpm.region import thickness as thick
    from snowmpm.region.elevations import as_geotiff, open_elevations
    from snowmpm.region.forest import open_forest
    from snowmpm.region.release_terrain import RULES

    if scenario not in RULES:
        raise InputError.not_in("--scenario", scenario, RULES)
    if thickness is not None and three_day_snow is not None:
        raise InputError("--thickness and --three-day-snow: give one of them")
    for name, value, most in (("--thickness", thickness, 20.0), ("--three-day-snow", three_day_snow, 20.0),
                              ("--cover", cover, 100.0)):
        if value is not None and not 0.0 < value <= most:
            raise InputError.at(name, value, f"must be above 0 and at most {most:g}")
    target = output or Path("release_areas.gpkg")
    if target.suffix.lower() != ".gpkg":
        raise InputError(f"-o {target}: must end in .gpkg")
    overwriting.reads(terrain)
    overwriting.guard(target)
    with (tempfile.TemporaryDirectory() as scratch,
          open_elevations(as_geotiff(terrain, scratch, "TERRAIN"), "TERRAIN") as elevations,
          open_forest(forest, elevations.grid, cover, "--forest") as trees):
        areas, system = found.release_areas(elevations, RULES[scenario], trees), elevations.grid.system
    if thickness is not None or three_day_snow is not None:
        given = thick.Thickness(value=thickness, three_day_snow=three_day_snow)
        areas = [thick.of(one, given) for one in areas]
    found.write(areas, target, scenario, system)
    total = sum(one.area for one in areas)
    if as_json:
        print_json({"file": str(target), "scenario": scenario, "areas": [one.fields(scenario) for one in areas]})
    elif not quiet:
        if thickness is None and three_day_snow is None:
            print("no thickness: --thickness or --three-day-snow gives one", file=sys.stderr)
        print(target)
        print(f"{len(areas)} release areas of {total / 1e6:.4g} km2 in plan, {total / len(areas):.4g} m2 each in the"
              " mean")
