"""The `snowmpm` program: its commands and its help text."""

from typing import Annotated

import typer

from snowmpm.cli import (
    campaign,
    chain,
    check,
    choose,
    compare,
    docs,
    element,
    events,
    export,
    gallery,
    grains,
    info,
    listing,
    maps,
    micro,
    new,
    plot,
    profile,
    region,
    release,
    release_areas,
    render,
    report,
    run,
    runout,
    strength,
    study,
)
from snowmpm.cli.command import Command
from snowmpm.cli.errors import guarded
from snowmpm.cli.help_text import PlainGroup
from snowmpm.registry import COMMANDS

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


for command in (
    Command("run", run.run),
    Command("new", new.new),
    Command("check", check.check, writes=False),
    Command("choose", choose.choose, writes=False),
    Command("runout", runout.runout),
    Command("profile", profile.profile),
    Command("chain", chain.chain),
    Command("release", release.release, computes=False),
    Command("release-areas", release_areas.release_areas, computes=False),
    Command("region", region.region),
    Command("list", listing.list_library, writes=False),
    Command("render", render.render, computes=False),
    Command("report", report.report, computes=False),
    Command("plot", plot.plot, computes=False),
    Command("maps", maps.maps, computes=False),
    Command("export", export.export, computes=False),
    Command("info", info.info, writes=False, computes=False),
    Command("compare", compare.compare, computes=False),
    Command("gallery", gallery.gallery),
    Command("element", element.element),
    Command("micro", micro.micro),
    Command("grains", grains.grains),
    Command("strength", strength.strength),
    Command("docs", docs.docs, writes=False, computes=False),
    Command("study", study.study),
    Command("sweep", campaign.sweep),
):
    COMMANDS.add(command)
    command.add_to(app)

campaigns = typer.Typer(help="Many runs of one scene, and one answer: probability maps, sensitivities, calibration.",
                        cls=PlainGroup, no_args_is_help=True)
for command in (
    Command("run", campaign.run),
    Command("status", campaign.status, writes=False, computes=False),
    Command("maps", campaign.maps, computes=False),
    Command("plot", campaign.plot, computes=False),
    Command("calibrate", campaign.calibrate),
):
    command.add_to(campaigns)
app.add_typer(campaigns, name="campaign")

observed = typer.Typer(help="Observed avalanches: what is known of them, and how near runs come to it.", cls=PlainGroup,
                       invoke_without_command=True)
observed.callback()(guarded(events.events, False, False))
for command in (
    Command("show", events.show, writes=False, computes=False),
    Command("get", events.get, writes=False, computes=False),
    Command("score", events.score),
):
    command.add_to(observed)
app.add_typer(observed, name="events")
