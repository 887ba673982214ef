"""`snowmpm region`: release areas, flows and maps of a whole region."""

import sys
from pathlib import Path
from typing import Annotated

import typer

from snowmpm.cli.options import Json, Quiet
from snowmpm.cli.table import print_json
from snowmpm.errors import InputError, SimulationError


def region(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="File of a region (.toml).")],
    output: Annotated[
        Path | None, typer.Option("-o", "--output", metavar="DIR", help="Folder; regions/<its name> by default.")
    ] = None,
    workers: Annotated[int | None, typer.Option(min=1, metavar="N", help="Worker processes; one a core by default.")
                       ] = None,
    scheduler: Annotated[
        str | None, typer.Option(metavar="ADDRESS|slurm", help="A Dask scheduler, or jobs of SLURM; else processes of"
                                                               " this machine.")
    ] = None,
    resume: Annotated[bool, typer.Option("--resume", help="Do the runs that are missing in DIR.")] = False,
    retry_failed: Annotated[bool, typer.Option("--retry-failed", help="With --resume: failed runs once more.")] = False,
    patience: Annotated[float, typer.Option(min=0.0, metavar="S", help="Seconds to wait for a scheduler that is gone.")
                        ] = 300.0,
    quiet: Quiet = False,
    as_json: Json = False,
):
    """Run a region: potential release areas of an elevation raster, a flow from each of them, and maps over all.

    Each release is a run of its own, on a window of the terrain that grows where the flow needs it. A run that fails is
    listed with its reason; a worker that dies loses its run's time since the last checkpoint. Writes peak depth, speed,
    pressure, classes, probability and frequency as cloud-optimised GeoTIFF and Zarr, outlines, a table of what is
    exposed, a QGIS project, and a page that opens in a browser. `snowmpm check FILE` says what it costs.
    """
    from snowmpm.region import launch, plan
    from snowmpm.region.spec import read_region

    if retry_failed and not resume:
        raise InputError("--retry-failed goes with --resume")
    found = read_region(file)
    folder = output or Path("regions") / found.name

    def say(text):
        if not quiet:
            print(text, file=sys.stderr)

    try:
        setting = launch.run_region(found, folder, scheduler, workers, resume, retry_failed, say, patience)
    except KeyboardInterrupt:
        raise KeyboardInterrupt(f"interrupted; --resume does the runs that are missing in {folder}") from None
    done = launch.index(setting)
    counts = launch.counts(setting, done)
    if any(one["failed"] for one in counts.values()) and not any(one["done"] for one in counts.values()):
        raise SimulationError(f"{folder}: every run failed; {plan.RESULTS} says why")
    lines = list(launch.told(setting, done))
    if as_json:
        print_json({"folder": str(folder), "scenarios": counts, "warnings": [line for line, warns in lines if warns]})
        return
    for line, warns in lines:
        if warns:
            print(f"warning: {line}", file=sys.stderr)
        elif not quiet:
            print(line)
    if not quiet:
        print(launch.costs(setting, done))
        print(folder / plan.MAPS / "index.html")


def is_region(name):
    """Whether a name of a scene is that of the file of a region."""
    if not str(name).endswith(".toml") or not Path(name).is_file():
        return False
    from snowmpm.region.spec import is_region
    from snowmpm.scenes.toml import parse

    return is_region(parse(Path(name)))


def check_region(file, as_json):
    """Print what a region holds and costs; nothing is kept."""
    import tempfile

    from snowmpm.campaigns import cluster
    from snowmpm.region import forecast, plan, preparing
    from snowmpm.region.spec import read_region

    found = read_region(file)
    cluster.require_cluster()
    with tempfile.TemporaryDirectory() as folder:
        setting = preparing.make(found, folder, copies=False)
        cost = forecast.forecast(setting, cluster.worker_count(found.cluster))
        if as_json:
            print_json({"areas": setting.areas, "cell": setting.cell, "runs": cost.runs, "seconds_each": cost.each,
                        "core_hours": cost.core_hours, "disk": cost.disk, "memory": cost.memory})
            return
        for name, count in setting.areas.items():
            areas = list(plan.read_areas(setting.folder, name))
            thick, volume = ([min(one), max(one)] for one in (
                [area.thickness for area in areas], [area.volume for area in areas]))
            print(f"{name}: {count} release areas, {thick[0]:.2f} to {thick[1]:.2f} m thick, {volume[0]:.2g} to"
                  f" {volume[1]:.2g} m3")
        print(cost.words)
