"""`snowmpm campaign`: many runs of one scene, and their answer; `snowmpm sweep`, its short form."""

import sys
from pathlib import Path
from typing import Annotated

import typer

from snowmpm.cli.options import Json, Quiet, SceneName, Settings, setting_values
from snowmpm.cli.table import print_facts, print_json
from snowmpm.errors import InputError, shown_line

File = Annotated[str, typer.Argument(metavar="FILE", help="Campaign file (.toml), or the name of one of the library.")]
Folder = Annotated[Path, typer.Argument(metavar="DIR", help="Folder of a campaign.")]
Output = Annotated[
    Path | None, typer.Option("-o", "--output", metavar="DIR", help="Folder; campaigns/<its name> by default.")
]
Workers = Annotated[int | None, typer.Option(min=1, metavar="N", help="Worker processes; one a core by default.")]
Scheduler = Annotated[
    str | None,
    typer.Option(metavar="ADDRESS|slurm", help="A Dask scheduler, or jobs of SLURM; else processes of this machine."),
]
Resume = Annotated[bool, typer.Option("--resume", help="Do the runs that are missing in DIR.")]
Retry = Annotated[bool, typer.Option("--retry-failed", help="With --resume: do failed runs once more.")]
Patience = Annotated[
    float, typer.Option(min=0.0, metavar="S", help="Seconds to wait for a scheduler that is gone.")
]
VariantName = Annotated[str | None, typer.Option("--variant", metavar="NAME", help="Of the campaign; else its first.")]


ENOUGH = 40
"""Runs: of fewer, less than two lie beyond a quantile of 5 or 95 % on average."""
MOST = 100
"""Rows that a sweep prints."""


def run(file: File, output: Output = None, workers: Workers = None, scheduler: Scheduler = None,
        resume: Resume = False, retry_failed: Retry = False, patience: Patience = 300.0, quiet: Quiet = False,
        as_json: Json = False):
    """Run a campaign: many runs of one scene, and maps, tables and sensitivities over all of them.

    Each run has a folder of its own, named after the hash of its scene. A run that fails is recorded with its reason;
    a worker that dies loses its run's time since the last checkpoint. --resume does what is missing, also after more
    runs were asked for.
    """
    from snowmpm.campaigns.library import find_campaign
    from snowmpm.campaigns.spec import read_campaign

    _conduct(read_campaign(find_campaign(file)), output, workers, scheduler, (resume, retry_failed, patience), quiet,
             as_json)


def sweep(scene: SceneName,
          values: Annotated[list[str], typer.Argument(metavar="KEY=a,b,c", help="Values of a key of the scene.")],
          output: Output = None, settings: Settings = None, workers: Workers = None, scheduler: Scheduler = None,
          resume: Resume = False, quiet: Quiet = False):
    """Run a scene with every combination of some values: one table, one plot.

    snowmpm sweep avalanche_depth_averaged terrain.friction.mu=0.2,0.25,0.3 bodies.0.shape.top=1.0,1.5
    """
    from snowmpm.campaigns.sweep import sweep_file

    file = sweep_file(scene, values, setting_values(settings))
    found = _conduct(file, output, workers, scheduler, (resume, False, 300.0), quiet, False)
    if not quiet:
        _print_rows(found)


def _print_rows(found):
    """The parameters and main numbers of each run, a row a run."""
    from snowmpm.campaigns.listing import listing

    for line in listing(found, MOST):
        print(f"  {line}")


def _conduct(file, output, workers, scheduler, again, quiet, as_json):
    from snowmpm.campaigns import scenarios
    from snowmpm.campaigns.launch import raise_if_all_failed, run_campaign
    from snowmpm.campaigns.report import write_pictures

    resume, retry, patience = again
    if retry and not resume:
        raise InputError("--retry-failed goes with --resume")
    folder = output or Path("campaigns") / file.name

    def say(text):
        if not quiet:
            print(text, file=sys.stderr)

    try:
        found = run_campaign(file, folder, scheduler=scheduler, workers=workers, resume=resume, retry=retry,
                             say=say, patience=patience)
    except KeyboardInterrupt:
        raise KeyboardInterrupt(f"interrupted; --resume does the runs that are missing in {folder}") from None
    raise_if_all_failed(found)
    written = write_pictures(found)
    written[1:1] = _write_scenarios(found)
    if as_json:
        print_json(_record(found))
    elif not quiet:
        _tell(found)
        for line in scenarios.told(found):
            print(f"  {line}")
        for path in written[: 1 + len(scenarios.FILES)] if scenarios.done(found) else written[:1]:
            print(path)
    return found


def _write_scenarios(campaign):
    """Write numbers and outlines of the scenarios of a campaign; -> the paths, [] of a campaign without."""
    from snowmpm.campaigns import scenarios

    found = scenarios.done(campaign)
    if not found:
        return []
    table, outlines = (campaign.folder / name for name in scenarios.FILES)
    written = [scenarios.write_numbers(found, table)]
    if all("peak_depth" in run.maps for _, run in found):
        from snowmpm.gis.scenarios import write_outlines

        written.append(write_outlines(found, outlines))
    return written


def status(folder: Folder, as_json: Json = False):
    """Print what is done in a campaign, and which runs failed; also while it goes on."""
    from snowmpm.campaigns.campaign import Campaign
    from snowmpm.campaigns.cluster import require_cluster

    require_cluster()
    found = Campaign(folder)
    if as_json:
        print_json(_record(found))
        return
    _tell(found)


def _record(found):
    from snowmpm.campaigns.answers import summary
    from snowmpm.campaigns.listing import shown_numbers
    from snowmpm.campaigns.order import on_the_finest

    return {"folder": str(found.folder), "runs": len(found.members), "done": found.done, "failures": found.failures,
            "numbers": summary(found.table), "grids": on_the_finest(found, shown_numbers(found))}


def _tell(found):
    from snowmpm.campaigns.answers import samples_the_parameters, summary
    from snowmpm.campaigns.listing import shown_numbers
    from snowmpm.campaigns.order import orders
    from snowmpm.quantities.table import quantity

    n = len(found.members)
    print_facts(f"{found.file.name}: {found.done} of {n} runs done" + (
        f", {len(found.failures)} failed" if found.failures else ""), {})
    for name, reason in list(found.failures.items())[:5]:
        print(f"  failed: {shown_line(name, 200)}: {shown_line(reason, 500)}")
    if not samples_the_parameters(found.file):  # shares of the runs of a grid mean nothing
        for line in orders(found, shown_numbers(found)):
            print(f"  {line}")
        return
    rows = {}
    for name, low, middle, high in summary(found.table)[:12]:
        one = quantity(name, dimension=found.dimension)
        rows[one.label] = f"{one.text(middle)}  (5 to 95 %: {one.text(low)} to {one.text(high)})"
    if rows:
        few = ", too few for quantiles of 5 and 95 %" if found.done < ENOUGH else ""
        print_facts(f"median of the {found.done} runs{few}", rows)


def maps(folder: Folder, output: Output = None, variant: VariantName = None, quiet: Quiet = False):
    """Write the maps of a campaign as GeoTIFF: probabilities with their intervals, quantiles, agreement."""
    from snowmpm.campaigns import scenarios
    from snowmpm.campaigns.campaign import Campaign
    from snowmpm.campaigns.cluster import require_cluster
    from snowmpm.campaigns.geotiff import write_geotiffs

    require_cluster()
    found = Campaign(folder, variant)
    if scenarios.has(found.file):
        raise InputError(f"{folder}: scenarios are no sample, so that shares of them are no probabilities; their"
                         f" outlines are in {folder / scenarios.FILES[1]}")
    for path in write_geotiffs(found, output or folder / "geotiff"):
        if not quiet:
            print(path)


def plot(folder: Folder, output: Output = None, variant: VariantName = None, quiet: Quiet = False):
    """Draw a campaign: probability maps, tornado and scatter plots, convergence; and its report page."""
    from snowmpm.campaigns.campaign import Campaign
    from snowmpm.campaigns.cluster import require_cluster
    from snowmpm.campaigns.report import write_pictures

    require_cluster()
    for path in write_pictures(Campaign(folder, variant), output):
        if not quiet:
            print(path)


def calibrate(file: File, output: Output = None, workers: Workers = None, scheduler: Scheduler = None,
              resume: Resume = False, quiet: Quiet = False, as_json: Json = False):
    """Find parameters that agree with what was observed: run-out, outline, deposit volume, front times.

    FILE has a table [calibration]; its parameters are the prior. Writes the posterior (posterior.csv and a picture),
    and forecast.toml, a campaign that draws from it.
    """
    from snowmpm.campaigns.calibration import calibrate_campaign
    from snowmpm.campaigns.library import find_campaign
    from snowmpm.campaigns.report import draw_posterior
    from snowmpm.campaigns.spec import read_campaign

    loaded = read_campaign(find_campaign(file))
    folder = output or Path("campaigns") / loaded.name
    found = calibrate_campaign(loaded, folder, scheduler=scheduler, workers=workers, resume=resume,
                               say=lambda text: None if quiet else print(text, file=sys.stderr))
    picture = draw_posterior(found, folder / "posterior.png")
    if as_json:
        print_json(found.record())
    elif not quiet:
        print_facts(f"posterior of {loaded.name}: {found.runs} runs in {found.generations} generations", found.facts())
        print(f"{picture}\n{folder / 'posterior.csv'}\nnext: snowmpm campaign run {folder / 'forecast.toml'}")

