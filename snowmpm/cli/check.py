"""`snowmpm check`: is a scene valid, what would be modelled, which of it is doubtful, and what it could do without."""

import textwrap

from snowmpm.cli.options import Json, PrecisionOption, SceneName, Settings, scene_overrides
from snowmpm.cli.table import line_length, print_facts, print_json
from snowmpm.cli.wording import duration


def check(scene: SceneName, settings: Settings = None, precision: PrecisionOption = None, as_json: Json = False):
    """Say what a scene will model, and at what expense.

    Warns of settings that lie beyond what a scheme bears, by the atlas of failures (`snowmpm study stability`), and
    names those that cure it; says what the scene pays for and what it could do without. Writes nothing. A wrong scene
    ends with exit code 2 and the key that is wrong.
    """
    from snowmpm.cli.options import Backend
    from snowmpm.cli.run import start_taichi
    from snowmpm.scenes import load_scene

    loaded = load_scene(scene, scene_overrides(settings, precision))
    start_taichi(Backend.cpu, None)
    from snowmpm.advice.report import advise

    advice = advise(loaded)
    if as_json:
        print_json({"scene": loaded.name, "source": loaded.source, **advice.record()})
        return
    print_facts(f"{loaded.name} ({loaded.source})", advice.facts)
    _print_payments(advice)
    _print_cautions(advice.cautions)
    _print_savings(advice.savings)


def _print_payments(advice):
    console = _console()
    console.print(f"\n[bold]pays for[/], of about {duration(advice.facts['run_time'])} on one thread")
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
        console.print("\n[bold]warnings[/]: none")
        return
    console.print(f"\n[bold yellow]warnings[/]: {len(cautions)}")
    for caution in cautions:
        console.print(f"  [bold]{_plain(caution.key)}[/]: {_plain(caution.says)}")
        console.print(f"      {caution.cure} (atlas: {caution.entry})", markup=False)


def _print_savings(savings):
    console = _console()
    if not savings:
        console.print("\n[bold]could do without[/]: nothing of it")
        return
    console.print("\n[bold]could do without[/]")
    for saving in savings:
        gained = f"saves {duration(saving.seconds)} ({saving.share:.0%})" if saving.seconds > 0.0 else "saves no time"
        console.print(f"  [bold]{_plain(saving.key)}[/]: {_plain(saving.says)}; {gained}")


def _console():
    from rich.console import Console

    return Console(highlight=False, soft_wrap=True)


def _plain(text):
    """Text whose brackets are no markup."""
    from rich.markup import escape

    return escape(text)
