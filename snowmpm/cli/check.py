"""`snowmpm check`: whether a scene is valid, what it models, what it costs, where it may fail, what could be saved."""

import shlex
import sys
import textwrap
from dataclasses import asdict

from snowmpm.cli import errors
from snowmpm.cli.choose import OF_RUNGS, faster_model, outlook, usual_ladder
from snowmpm.cli.options import Accurate, Fast, Json, PrecisionOption, SceneName, Settings, scene_overrides
from snowmpm.cli.region import check_region, is_region
from snowmpm.cli.table import line_length, print_facts, print_json
from snowmpm.cli.wording import duration
from snowmpm.errors import InputError


def check(
    scene: SceneName,
    settings: Settings = None,
    precision: PrecisionOption = None,
    fast: Fast = False,
    accurate: Accurate = False,
    as_json: Json = False,
):
    """Print what a scene models and what it costs.

    Of the file of a region (`snowmpm region`): its release areas, and what its runs cost.
    Warns of settings beyond the measured limits of a scheme (`snowmpm study stability`), and names the settings that
    cure them. Lists the costs of the scene and what could be saved. Writes nothing. An invalid scene ends with exit
    code 2 and the name of the wrong key.
    """
    if is_region(scene):
        if settings or precision or fast or accurate:
            raise InputError(f"{scene}: --set, --precision, --fast and --accurate go with scenes, not with the file of"
                             " a region")
        return check_region(scene, as_json)
    import snowmpm.compiler  # noqa: F401 (before the laws are read, which then takes a third of a second less)
    from snowmpm.cli.options import Backend
    from snowmpm.cli.run import along_the_front, start_taichi
    from snowmpm.scenes import load_scene

    overrides = scene_overrides(settings, precision)
    loaded = load_scene(scene, overrides)
    start_taichi(Backend.cpu, None)
    if fast or accurate:
        loaded = load_scene(scene, overrides | along_the_front(loaded, fast, accurate, quiet=False))
    from snowmpm.advice.affordability import many_bodies
    from snowmpm.advice.report import advise

    if many := many_bodies(loaded):
        print(f"warning: {many}", file=sys.stderr)
    advice = advise(loaded)
    usual = usual_ladder(loaded, advice.scene_facts)
    if as_json:
        print_json({"scene": loaded.name, "source": loaded.source, **advice.record(),
                    "along": [asdict(one) for one in _with_models(usual, advice)],
                    "models": outlook(usual)})
        return
    print_facts(f"{loaded.name} ({loaded.source})", advice.facts)
    kept = [word for one in settings or () if one.partition("=")[0].strip() not in OF_RUNGS for word in ("--set", one)]
    _print_models(outlook(usual), shlex.join(["snowmpm", "choose", str(scene), *kept]))
    _print_payments(advice)
    if advice.unaffordable:
        _console().print(f"\n[bold red]out of reach[/]: {_plain(advice.unaffordable)}; run refuses it without"
                         " --accept-cost")
    _print_cautions(advice.cautions)
    _print_savings(advice.savings)
    if not fast and not accurate:
        _print_alternatives(_with_models(usual, advice))


def _print_models(found, command):
    """Two lines of an `outlook`: how good the scene as it is answers, and the cheapest model that would do. command:
    that says more."""
    console = _console()
    if found is None:
        console.print("\n[bold]asked for[/] none of the questions of snowmpm choose")
        return
    console.print(f"\n[bold]asked for[/] {found['words']}: as it is, {found['own']}, {found['own_error']}")
    best = found["chosen"]
    if best:
        console.print(f"  {best}, {duration(found['seconds'])}: {found['error']} ({found['reason']}; {command})",
                      markup=False)
    else:
        console.print(f"  {command} lists other models ({found['reason']})", markup=False)


def _print_payments(advice):
    from snowmpm.advice.budget import WITHIN

    console = _console()
    time = duration(advice.facts["run_time"])
    console.print(f"\n[bold]pays for[/], of about {time} of processor time on one thread of this machine, within"
                  f" {WITHIN:.0%} as a rule;\nmore where snow spreads far or outruns sound in it, less where it comes"
                  " to rest early")
    width = max(len(payment.what) for payment in advice.payments)
    for payment in advice.payments:
        share = "" if payment.share is None else f"{payment.share:.0%}"
        label = f"  {payment.what:<{width}}  {share:>4}  "
        rows = textwrap.wrap(payment.detail, max(line_length() - len(label), 30), break_on_hyphens=False)
        for row, before in zip(rows, [label, *[" " * len(label)] * len(rows)], strict=False):
            console.print(f"{before}{row}", markup=False)


def _print_cautions(cautions):
    console = _console()
    if not cautions:
        console.print(f"\n[bold]warnings[/]: none{' besides those above' if errors.told else ''}")
        return
    console.print(f"\n[bold yellow]warnings[/]: {len(cautions)}")
    for caution in cautions:
        console.print(f"  [bold]{_plain(caution.key)}[/]: {_plain(caution.says)}")
        console.print(f"      {caution.advice}", markup=False)


def _print_savings(savings):
    console = _console()
    if not savings:
        console.print("\n[bold]could do without[/]: nothing of it")
        return
    console.print("\n[bold]could do without[/]")
    for saving in savings:
        gained = f"saves {duration(saving.seconds)} ({saving.share:.0%})" if saving.seconds > 0.0 else "saves no time"
        console.print(f"  [bold]{_plain(saving.key)}[/]: {_plain(saving.says)}; {gained}")


def _with_models(usual, advice):
    """`Alternative`s; in place of a --fast that changes nothing the next cheaper model of a `usual_ladder`."""
    from snowmpm.advice.report import Alternative

    fast = next((one for one in advice.along if one.option == "--fast"), None)
    if fast and fast.seconds < advice.facts["run_time"]:
        return advice.along
    model = faster_model(usual, advice.facts["run_time"])
    if model is None:
        return advice.along
    return [Alternative("--fast", model["seconds"], model["lines"]),
            *(one for one in advice.along if one.option != "--fast")]


def _print_alternatives(along):
    console = _console()
    for alternative in along:
        console.print(f"\n[bold]{alternative.option}[/]: about {duration(alternative.seconds)}")
        for line in alternative.lines:
            console.print(f"  {line.removeprefix(alternative.option).lstrip(': ')}", markup=False)


def _console():
    from rich.console import Console

    return Console(highlight=False, soft_wrap=True)


def _plain(text):
    """Text with its brackets escaped, so that they are not markup."""
    from rich.markup import escape

    return escape(text)
