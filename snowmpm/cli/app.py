"""The `snowmpm` program: its commands and its help text."""

from typing import Annotated

import typer

from snowmpm.cli import (
    campaign,
    check,
    compare,
    docs,
    element,
    export,
    gallery,
    grains,
    info,
    listing,
    maps,
    micro,
    new,
    plot,
    render,
    report,
    run,
    strength,
    study,
)
from snowmpm.cli.errors import guarded
from snowmpm.cli.help_text import PlainCommand, PlainGroup

HELP = """Snow and avalanche mechanics: from the failure of a weak layer to the deposit, in one model.

`run` turns a scene (TOML) into a run file, and `render` draws a film of it:

\b
    snowmpm run slab_release_2d -o runs/first
    snowmpm render runs/first -o first.mp4

Exit codes: 0 done, 1 the simulation failed, 2 bad input, 130 interrupted.
"""

app = typer.Typer(help=HELP, cls=PlainGroup, no_args_is_help=True, pretty_exceptions_enable=False)


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


app.command("run", cls=PlainCommand)(guarded(run.run))
app.command("new", cls=PlainCommand)(guarded(new.new))
app.command("check", cls=PlainCommand)(guarded(check.check, writes=False))
app.command("list", cls=PlainCommand)(guarded(listing.list_library, writes=False))
app.command("render", cls=PlainCommand)(guarded(render.render))
app.command("report", cls=PlainCommand)(guarded(report.report))
app.command("plot", cls=PlainCommand)(guarded(plot.plot))
app.command("maps", cls=PlainCommand)(guarded(maps.maps))
app.command("export", cls=PlainCommand)(guarded(export.export))
app.command("info", cls=PlainCommand)(guarded(info.info, writes=False))
app.command("compare", cls=PlainCommand)(guarded(compare.compare))
app.command("gallery", cls=PlainCommand)(guarded(gallery.gallery))
app.command("element", cls=PlainCommand)(guarded(element.element))
app.command("micro", cls=PlainCommand)(guarded(micro.micro))
app.command("grains", cls=PlainCommand)(guarded(grains.grains))
app.command("strength", cls=PlainCommand)(guarded(strength.strength))
app.command("docs", cls=PlainCommand)(guarded(docs.docs, writes=False))
app.command("study", cls=PlainCommand)(guarded(study.study))
app.command("sweep", cls=PlainCommand)(guarded(campaign.sweep))

campaigns = typer.Typer(help="Many runs of one scene, and one answer: probability maps, sensitivities, calibration.",
                        cls=PlainGroup, no_args_is_help=True)
for made in (campaign.run, campaign.status, campaign.maps, campaign.plot, campaign.calibrate):
    campaigns.command(made.__name__, cls=PlainCommand)(guarded(made, writes=made is not campaign.status))
app.add_typer(campaigns, name="campaign")
