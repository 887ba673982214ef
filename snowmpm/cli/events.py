"""`snowmpm events`: observed avalanches, and how near runs come to them."""

import itertools
import shlex
import sys
from pathlib import Path
from typing import Annotated

import typer

from snowmpm.cli.options import Backend, Json, Quiet, Settings, setting_values
from snowmpm.cli.table import print_facts, print_json
from snowmpm.errors import InputError

Name = Annotated[str, typer.Argument(metavar="NAME", help="Name of an event; `snowmpm events` has them.")]
Accept = Annotated[bool, typer.Option("--accept-licence", help="Accept the licence of the data.")]
Workers = Annotated[int | None, typer.Option(min=1, metavar="N", help="Worker processes; one a core by default.")]
Only = Annotated[
    list[str] | None,
    typer.Option("--only", metavar="WORD", help="Only ways whose name holds this word, and the default; repeatable."),
]
Output = Annotated[
    Path | None, typer.Option("-o", "--output", metavar="DIR", help="Folder; campaigns/event_NAME by default.")
]
Resume = Annotated[bool, typer.Option("--resume", help="Do the runs that are missing in DIR.")]


def events(context: typer.Context, as_json: Json = False):
    """List observed avalanches: what was observed, licence, whether their files are here. Commands tell of one, fetch
    its files, and compare runs with it."""
    if context.invoked_subcommand:
        return
    from snowmpm.events import store

    found, wrong = {}, []
    for name in store.events():
        try:
            found[name] = store.event(name)
        except InputError as error:  # the others can be listed
            wrong.append(str(error))
    rows = {name: {"title": one.title, "observed": _observed(one), "licence": one.licence,
                   "here": store.is_here(name), "bring": [file.name for file in one.brought]}
            for name, one in found.items()}
    if as_json:
        print_json(rows)
        return
    for name, row in rows.items():
        here = "files are here" if row["here"] else f"you bring {', '.join(row['bring'])}" if row["bring"] else (
            "files are fetched when used")
        print(f"{name}\n    {row['title']}\n    observed: {row['observed']}; licence {row['licence']}; {here}")
    for message in wrong:
        print(f"warning: {message}")
    print("\nsnowmpm run event:NAME computes one, snowmpm events show NAME tells of it, snowmpm events score NAME"
          " compares ways to compute it")


def show(name: Name, as_json: Json = False):
    """Tell what is known of an event, what is assumed, and what its licence allows."""
    from snowmpm.events import store
    from snowmpm.events.page import facts

    one = store.event(name)
    if as_json:
        print_json(one.model_dump(mode="json", exclude_none=True))
        return
    print_facts(one.title, facts(one))
    print("\nassumed")
    for text in one.assumed:
        print(f"  - {text}")


def get(name: Name, accept_licence: Accept = False, quiet: Quiet = False):
    """Fetch the files of an event, and print its scene, which lies in the folder that keeps them all."""
    from snowmpm.events import store
    from snowmpm.events.scoring import Observation

    path = store.scene_file(name, accept_licence, quiet)
    Observation.of(name)  # what was observed can be read
    if not quiet:
        one = store.event(name)
        print(f"{path}\ndata by {one.credit}, {one.licence}: {one.uses}")


def score(name: Name, output: Output = None, only: Only = None, settings: Settings = None, workers: Workers = None,
          resume: Resume = False, quiet: Quiet = False, as_json: Json = False):
    """Compute an event with every class of friction and by other methods, and score each against what was observed.

    A campaign with a run a way; with --set one more way is computed. Writes scores.csv, a page of the event with a map
    (event.html), and what `snowmpm campaign run` writes.
    """
    from snowmpm import overwriting
    from snowmpm.campaigns import event_scores
    from snowmpm.campaigns.launch import raise_if_all_failed, run_campaign
    from snowmpm.cli.run import start_taichi
    from snowmpm.events import store

    file = event_scores.event_file(name, tuple(only or ()), setting_values(settings))
    folder = output or Path("campaigns") / file.name
    overwriting.guard_in(folder, event_scores.FILES)
    asked = [*(("--only", word) for word in only or ()), *(("--set", text) for text in settings or ())]
    command = shlex.join(["snowmpm", "events", "score", name, *itertools.chain.from_iterable(asked)])

    def say(text):
        if not quiet:
            print(text, file=sys.stderr)

    try:
        campaign = run_campaign(file, folder, workers=workers, resume=resume, say=say)
    except KeyboardInterrupt:
        raise KeyboardInterrupt(f"interrupted; --resume does the runs that are missing in {folder}") from None
    raise_if_all_failed(campaign)
    found, observation = event_scores.score_event(name, campaign)
    start_taichi(Backend.cpu, 1)
    models = event_scores.without_flow(name, observation)
    written = [event_scores.write_scores(found, folder / event_scores.FILES[0]),
               *event_scores.write_event_page(name, campaign, found, observation, command, models)]
    if models:
        written.append(event_scores.write_models(models, folder / event_scores.FILES[3]))
    if as_json:
        print_json({one.way: one.numbers for one in found})
    elif not quiet:
        for line in event_scores.lines(found, store.event(name)):
            print(line)
        print(event_scores.said(found))
        for line in ("", *models.lines) if models else ():
            print(line)
        for failed, reason in campaign.failures.items():
            print(f"failed: {failed}: {reason}")
        for path in written:
            print(path)


def _observed(one):
    seen = one.observed
    number = len(seen.values)
    words = {"outline": seen.outline, "deposit": seen.deposit, "where it stopped": seen.stopped,
             "deposit volume": seen.deposit_volume, "a value" if number == 1 else f"{number} values": seen.values}
    return ", ".join(word for word, value in words.items() if value)
