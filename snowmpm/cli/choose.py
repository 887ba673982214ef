"""`snowmpm choose`: the cheapest model that answers a question about a scene; and `snowmpm run --question`."""

import math
from pathlib import Path
from typing import Annotated

import typer

from snowmpm import overwriting
from snowmpm.cli.options import Backend, Json, SceneName, Settings, scene_overrides
from snowmpm.cli.table import print_json
from snowmpm.cli.wording import duration
from snowmpm.errors import InputError

NAMES = ("run-out", "affected-area", "peak-pressure", "load", "deposit-volume", "critical-length", "crack-speed",
         "release", "factor-of-safety", "settlement")
LONGEST = 600.0
"""Time [s] that may be taken to confirm an answer, where no budget is given."""

Question = Annotated[
    str | None, typer.Option(metavar="NAME", help=f"What is asked of the scene: {', '.join(NAMES)}.")]
Within = Annotated[
    str | None, typer.Option(metavar="P%", help="Largest error that will do, such as 10%; nine of ten answers lie"
                                                " within.")]
BudgetOption = Annotated[
    str | None, typer.Option("--budget", metavar="TIME", help="Processor time for the answer: 60s, 5min, 1h.")]
At = Annotated[
    str | None, typer.Option("--at", metavar="X,Y", help="Place of peak-pressure, in map coordinates.")]
ObstacleName = Annotated[
    str | None, typer.Option("--obstacle", metavar="NAME", help="Whose load is asked; all together by default.")]
PathOption = Annotated[
    Path | None, typer.Option("--path", metavar="FILE", help="A line (.shp, .geojson or .gpkg) for models along a path;"
                                                             " the way of most snow by default.")]
RungName = Annotated[
    str | None, typer.Option("--rung", metavar="NAME", help="Take this rung of `snowmpm choose`, as it is.")]


def choose(
    scene: SceneName,
    question: Question = None,
    within: Within = None,
    budget: BudgetOption = None,
    settings: Settings = None,
    at: At = None,
    obstacle: ObstacleName = None,
    path: PathOption = None,
    as_json: Json = False,
):
    """Find the cheapest model that answers a question about a scene.

    Prints the ladder of this scene: each model and grid with its processor time, its memory, the interval in which nine
    of ten of its answers lie, and what it leaves out. Picks the cheapest that is within the error, 10 % where none is
    given; with --budget the best within the time. Without --question, what the scene is usually asked. `snowmpm run
    SCENE --question ...` runs what is picked; `snowmpm docs models` tells how the errors were measured.
    """
    from snowmpm.ladder.ladder import choose as pick

    loaded, ask, ladder = opened(scene, settings, question, at, obstacle, path)
    wanted, limit = asked_for(within, budget)
    chosen, reason = pick(ladder.steps, wanted, limit)
    if as_json:
        print_json(_record(loaded, ask, ladder, chosen, reason))
        return
    print(f"{loaded.name}: {ask.question.label}. {ask.question.says}")
    for line in table_of(ladder, chosen):
        print(line)
    for line in _refused(ladder):
        print(f"  not here: {line}")
    print(f"this scene as it is: {ladder.own}")
    if chosen is None:
        words = _command(scene, ask, None, None, at, obstacle, path, settings)
        print(f"no choice: {reason}" + (f"; --rung takes one: {words} --rung '{ladder.steps[0].name}'"
                                        if ladder.steps else ""))
        return
    print(f"take: {chosen.name} ({reason}); it leaves out {chosen.rung.blind}")
    print(f"next: {_command(scene, ask, within, budget, at, obstacle, path, settings)}")


def opened(name, settings, question, at, obstacle, path, rung=None, start=True):
    """(scene, `Ask`, `Ladder`) of a scene and a question in words. rung: the only one that is wanted; start: whether
    nothing computes yet. Raises InputError."""
    import snowmpm.compiler  # noqa: F401 (before the laws are read, which then takes a third of a second less)
    from snowmpm.cli.run import start_taichi
    from snowmpm.ladder.ladder import ladder_of
    from snowmpm.ladder.questions import QUESTIONS, Ask, usual_question
    from snowmpm.scenes import load_scene

    overrides = scene_overrides(settings)
    refuse_what_rungs_set(overrides)
    loaded = load_scene(name, overrides)
    name = question or usual_question(loaded)
    if name is None:
        raise InputError(f"{loaded.source}: give --question NAME, one of {', '.join(QUESTIONS)}: a scene like this is"
                         " asked none of them as a rule")
    ask = Ask.of(loaded, name, place_of(at), obstacle, _path(path, loaded))
    if start:
        start_taichi(Backend.cpu, None)
    return loaded, ask, ladder_of(loaded, ask, rung)


OF_RUNGS = {"solver", "solver.dx", "solver.method"}
"""Keys that a rung sets."""
USUAL = 0.1
"""Error that will do where none was given [-]."""


def usual_ladder(scene, facts):
    """(`Ask`, `Ladder`) of what a scene is usually asked; None of one that is asked nothing. facts: `SceneFacts`."""
    from snowmpm.ladder.ladder import ladder_of
    from snowmpm.ladder.questions import Ask, usual_question

    name = usual_question(scene)
    if name is None:
        return None
    ask = Ask.of(scene, name)
    return ask, ladder_of(scene, ask, facts=facts)


def outlook(usual):
    """What `check` says of a `usual_ladder`: the question, the error of the scene as it is, the rung that would do with
    `USUAL` error; None of None."""
    from snowmpm.ladder.ladder import choose as pick

    if usual is None:
        return None
    ask, ladder = usual
    own = next((step.expected for step in ladder.steps if step.name == ladder.own), None)
    chosen, reason = pick(ladder.steps, USUAL, None)
    return {"question": ask.question.name, "words": ask.question.label, "own": ladder.own,
            "own_error": _error(own), "chosen": chosen and chosen.name, "seconds": chosen and chosen.seconds,
            "error": chosen and _error(chosen.expected), "reason": reason}


def faster_model(usual, seconds):
    """What `--fast` takes where nothing in the scheme is faster: changes to another model or grid, its seconds, and
    lines about it. None for a scene that is asked nothing; no changes where none will do, with the next cheaper run and
    what it costs. usual: `usual_ladder`; seconds: of the scene as it is."""
    from snowmpm.ladder.ladder import faster

    if usual is None:
        return None
    ask, ladder = usual
    step = faster(ladder.steps, seconds)
    if step is not None:
        return {"changes": dict(step.rung.changes), "seconds": step.seconds, "lines": (
            f"--fast: {step.name}, about {duration(step.seconds)}; {ask.question.label}: {_error(step.expected)}",
            f"it leaves out {step.rung.blind}")}
    cheaper = [one for one in ladder.steps if one.rung.changes is not None and one.seconds < seconds
               and one.name != ladder.own]
    if not cheaper:
        return None
    step = max(cheaper, key=lambda one: one.seconds)
    return {"changes": {}, "seconds": seconds, "lines": (
        f"--fast: changes nothing: the next cheaper, {step.name}, takes {duration(step.seconds)} for"
        f" {duration(seconds)}; {ask.question.label}: {_error(step.expected)}",)}


def _error(expected):
    if expected is not None and expected.yes_no:
        return expected.words
    return f"error {interval(expected)}"


def refuse_what_rungs_set(overrides):
    """Raise InputError for a key of `--set` that a rung would replace."""
    if taken := sorted(OF_RUNGS & overrides.keys()):
        raise InputError(f"--set {taken[0]}: the rungs say that themselves; leave it out, or run the scene as it is")


def share_of(text):
    """A share [-] from 10%, 10 % or 0.1; None of None. Raises InputError."""
    if text is None:
        return None
    number = text.strip().removesuffix("%").strip()
    try:
        share = float(number) / (100.0 if text.strip().endswith("%") else 1.0)
    except ValueError:
        share = math.nan
    if not 0.0 < share < 10.0:
        raise InputError.at("--within", text, "must be a share from 0 to 10 (1000 %), such as 20% or 0.2")
    return share


def asked_for(within, budget):
    """(error [-], time [s]) of --within and --budget, None for none; `USUAL` error where neither is given."""
    share, seconds = share_of(within), seconds_of(budget)
    return (USUAL if share is None and seconds is None else share), seconds


def seconds_of(text):
    """Seconds from 60, 60s, 5min or 1h; None of None. Raises InputError."""
    if text is None:
        return None
    given = text.strip()
    for unit, size in (("min", 60.0), ("h", 3600.0), ("s", 1.0), ("", 1.0)):
        if given.endswith(unit):
            try:
                seconds = size * float(given.removesuffix(unit))
            except ValueError:
                break
            if 0.0 < seconds < math.inf:
                return seconds
            break
    raise InputError.at("--budget", text, "must be a time above 0, such as 60s, 5min or 1h")


def place_of(text):
    """[x, y] from X,Y; None of None. Raises InputError."""
    if text is None:
        return None
    try:
        place = [float(part) for part in text.split(",")]
    except ValueError:
        place = []
    if len(place) != 2 or not all(map(math.isfinite, place)):
        raise InputError.at("--at", text, "must be X,Y in map coordinates, such as 600350,200120")
    return place


def _path(path, scene):
    if path is None:
        return None
    from snowmpm.gis.lines import the_line
    from snowmpm.ladder.flows import is_on_terrain

    overwriting.reads(path)
    if not is_on_terrain(scene):
        raise InputError("--path goes with flows on terrain in three dimensions")
    return lambda system: the_line(path, system)


def interval(expected):
    """An `Expected` error in words."""
    return "not measured" if expected is None else expected.words


def table_of(ladder, chosen=None):
    """Lines of the steps of a `Ladder`, cheap to dear, the chosen one marked."""
    rows = [("", "model", "time", "memory", "error", "problems")]
    for step in ladder.steps:
        rows.append((">" if chosen is step else "", step.name, duration(step.seconds),
                     "-" if step.memory is None else _memory(step.memory), interval(step.expected),
                     str(step.expected.n) if step.expected else ""))
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    for row in rows:
        yield (f"{row[0]:<2}{row[1]:<{widths[1]}}  {row[2]:>{widths[2]}}  {row[3]:>{widths[3]}}  {row[4]:<{widths[4]}}"
               f"  {row[5]:>{widths[5]}}").rstrip()
    blind = {step.name.partition(", ")[0]: step.rung.blind for step in ladder.steps}
    for kind, what in blind.items():
        yield f"  {kind} leaves out {what}"


def _memory(size):
    return f"{size / 2**30:.1f} GiB" if size >= 2**30 else f"{size / 2**20:.0f} MiB"


def _refused(ladder):
    """Lines of the rungs that a scene cannot stand on, those of one method and reason together."""
    together = {}
    for name, why in ladder.refused.items():
        method, _, cells = name.partition(", ")
        together.setdefault((method, why), []).append(cells)
    for (method, why), cells in together.items():
        yield f"{method}{', ' if cells[0] else ''}{cells[0]}{f' to {cells[-1]}' if len(cells) > 1 else ''}: {why}"


def check_question(scene, question):
    """Raise InputError where a scene cannot answer a question by a run of its own."""
    from snowmpm.ladder.questions import QUESTIONS, STRENGTH, Ask

    if Ask.of(scene, question).question.group == STRENGTH:
        raise InputError(f"--question {QUESTIONS[question].name}: is answered by no single run; `snowmpm run SCENE"
                         f" --question {question}` makes those that it takes")


def rewritten(text, load, question, within, budget=None):
    """(text of a scene on the rung that answers a question within an error or a time, a line about it, the rung's
    name), with the comments where only values change. text: as it is; load: text -> `Scene`, its file in the folder of
    the new one. Raises InputError where no rung that is a scene has a measured error."""
    from snowmpm.ladder.ladder import choose as pick
    from snowmpm.ladder.ladder import ladder_of
    from snowmpm.ladder.questions import Ask
    from snowmpm.scenes.edited import edited
    from snowmpm.scenes.loader import with_overrides

    scene = load(text)
    ladder = ladder_of(scene, Ask.of(scene, question))
    steps = [step for step in ladder.steps if step.rung.changes is not None and not step.rung.trials]
    chosen, reason = pick(steps, *asked_for(within, budget))
    if chosen is None:
        raise InputError(f"--question {question}: {reason}")
    wanted, head = with_overrides(scene, chosen.rung.changes), [one for one in text.split("\n") if one[:1] == "#"]
    resolved = "\n".join([*head, wanted.to_toml().replace(f"{scene.base_dir.resolve()}/", "")])
    try:
        short = edited(text, chosen.rung.changes)
        text = short if load(short).model_dump() == wanted.model_dump() else resolved
    except (InputError, TypeError):  # a table that takes the place of another
        text = resolved
    return text, (f"{chosen.name} ({reason}): {question} {_error(chosen.expected)}, about"
                  f" {duration(chosen.seconds)} of processor time"), chosen.name


def _command(scene, ask, within, budget, at, obstacle, path, settings):
    import shlex

    words = ["snowmpm", "run", scene, "--question", ask.question.name]
    for option, value in (("--within", within), ("--budget", budget), ("--at", at), ("--obstacle", obstacle),
                          ("--path", path)):
        words += [] if value is None else [option, str(value)]
    for setting in settings or ():
        words += ["--set", setting]
    return shlex.join(words)


def _record(scene, ask, ladder, chosen, reason):
    from dataclasses import asdict

    return {"scene": scene.name, "question": ask.question.name, "definition": ask.question.says,
            "unit": ask.question.unit, "own": ladder.own, "chosen": chosen and chosen.name, "reason": reason,
            "rungs": [{"rung": step.name, "seconds": step.seconds, "memory": step.memory, "blind": step.rung.blind,
                       "expected_error": step.expected and asdict(step.expected)} for step in ladder.steps],
            "refused": ladder.refused}


def answer(loaded, ask, ladder, folder, simulate, within=None, budget=None, rung=None, quiet=False, as_json=False):
    """Run what is chosen, and what confirms it; print the answers. simulate: (scene, folder) -> `Run`."""
    from snowmpm.ladder import climb
    from snowmpm.ladder.ladder import choose as pick
    from snowmpm.ladder.ladder import next_up

    if rung:
        chosen, reason = ladder.step(rung), "as was asked"
    else:
        chosen, reason = pick(ladder.steps, within, budget)
    if chosen is None:
        raise InputError(f"--question {ask.question.name}: {reason}; --rung NAME takes one of"
                         f" {'; '.join(step.name for step in ladder.steps)}")
    told, following = not quiet and not as_json, None if rung else next_up(ladder.steps, chosen)
    limit = chosen.seconds if rung else chosen.seconds + LONGEST if budget is None else budget
    if told:
        print(f"{chosen.name} ({reason}), about {duration(chosen.seconds)}"
              + (f"; then {following.name} to confirm it, about {duration(following.seconds)}"
                 if following and following.seconds <= limit - chosen.seconds else ""))

    def say(found):
        if told:
            print(f"{found.step.name}: {in_words(ask, found)}")

    answers = climb.climb(loaded, ask, ladder, chosen, folder, simulate, limit, say)
    known = [one for one in answers if one.value is not None]
    agreed = climb.agree(ask, *known[-2:]) if len(known) > 1 else None
    path = climb.write(folder, loaded, ask, answers, agreed)
    if told:
        print(path)
        print(f"{loaded.name}, {in_words(ask, known[-1])}; {_verdict(answers, agreed, following, rung)}")
    if as_json:
        last = known[-1]
        print_json({"question": ask.question.name, "value": last.value, "unit": ask.question.unit,
                    "between": last.between, "wrong": last.step.expected.error if ask.question.yes_no
                    and last.step.expected else None, "rung": last.step.name, "agreed": agreed, "answer": str(path)})


def in_words(ask, found):
    """An answer with the interval in which the truth is expected."""
    question, expected = ask.question, found.step.expected
    if found.value is None:
        return f"gives no {question.label}" + (f": {found.why}" if found.why else "")
    if question.yes_no:
        return f"{question.label}: {'yes' if found.value else 'no'}" + (f", {expected.words}" if expected else "")
    from snowmpm.quantities.quantity import written

    said = f"{question.label} {written(found.value, question.unit)}"
    if expected is None:
        return f"{said}, its error was not measured"
    if found.between is None:
        return f"{said}: too little to tell an error"
    low, high = found.between
    bias = "" if low <= found.value <= high else f" (this model tells too {'little' if found.value < low else 'much'})"
    low, high = (written(one, question.unit) for one in (low, high))
    return f"{said}; the truth between {low} and {high} in nine of ten cases{bias}"


def _verdict(answers, agreed, following, rung):
    """Whether the last answer is confirmed, or why not. answers: of all rungs that were tried."""
    known = [one.step.name for one in answers if one.value is not None]
    failed = [one.step.name for one in answers if one.value is None]
    if agreed:
        return f"confirmed by {known[-1]}"
    if agreed is False:
        return (f"not confirmed: {known[-2]} and {known[-1]} differ by more than was expected, and no dearer rung is"
                " left or affordable")
    if failed:
        return f"not confirmed: {' and '.join(failed)} gave no answer"
    if rung or following is None:
        return f"not confirmed: {'--rung takes one' if rung else 'no rung is as good and dearer'}"
    return f"not confirmed: {following.name} would take {duration(following.seconds)} more"
