"""The `snowmpm` program: its commands and its help text."""

from typing import Annotated

import typer

from snowmpm.cli import (
    campaign,
    check,
    compare,
    element,
    export,
    gallery,
    info,
    listing,
    maps,
    micro,
    new,
    plot,
    render,
    report,
    run,
    study,
)
from snowmpm.cli.errors import guarded

HELP = """Snow and avalanche mechanics: from the failure of a weak layer to the deposit, in one model.

`run` turns a scene (TOML) into a run file, and `render` draws a film of it:

\b
    snowmpm run slab_release_2d -o runs/first
    snowmpm render runs/first -o first.mp4

Exit codes: 0 done, 1 the simulation failed, 2 bad input, 130 interrupted.
"""

app = typer.Typer(help=HELP, no_args_is_help=True, pretty_exceptions_enable=False)


def _version(wanted: bool):
    if wanted:
        from snowmpm import __version__

        print(f"snowmpm {__version__}")
        raise typer.Exit


@app.callback()
def about(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Show the version.")
    ] = False,
):
    """Options that precede a command."""


app.command("run")(guarded(run.run))
app.command("new")(guarded(new.new))
app.command("check")(guarded(check.check))
app.command("list")(guarded(listing.list_library))
app.command("render")(guarded(render.render))
app.command("report")(guarded(report.report))
app.command("plot")(guarded(plot.plot))
app.command("maps")(guarded(maps.maps))
app.command("export")(guarded(export.export))
app.command("info")(guarded(info.info))
app.command("compare")(guarded(compare.compare))
app.command("gallery")(guarded(gallery.gallery))
app.command("element")(guarded(element.element))
app.command("micro")(guarded(micro.micro))
app.command("study")(guarded(study.study))
app.command("sweep")(guarded(campaign.sweep))

campaigns = typer.Typer(help="Many runs of one scene, and one answer: probability maps, sensitivities, calibration.",
                        no_args_is_help=True)
for made in (campaign.run, campaign.status, campaign.maps, campaign.plot, campaign.calibrate):
    campaigns.command(made.__name__)(guarded(made))
app.add_typer(campaigns, name="campaign")
