"""Error and processor time of every model, question by question, on problems with an answer.

Each problem is answered by every rung that its scene can stand on, each as a command of its own on one thread. Writes
the table that ships with the program (`snowmpm.measured.models`), and a chart for each question with the front of what
nothing beats in both error and time.
"""

import json
import resource
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from snowmpm.draft import write_table, write_text
from snowmpm.errors import InputError, SimulationError
from snowmpm.io import Run
from snowmpm.ladder import climb
from snowmpm.ladder.answers import answer_of
from snowmpm.ladder.ladder import ladder_of
from snowmpm.ladder.problems import PROBLEMS, Known, of_data
from snowmpm.ladder.questions import QUESTIONS, Ask
from snowmpm.measured import models
from snowmpm.measured.models import COLUMNS, Row
from snowmpm.scenes.loader import load_scene, with_overrides
from snowmpm.stages import counted

TABLE = "models.csv"
QUICK = 30.0
"""Forecast of the rungs of the short form [s]."""


def study(folder, *, quick=False, only=(), say=print):
    """Measure and draw; -> paths. only: names of problems; rows of the others stay in the folder's table."""
    problems = PROBLEMS | of_data()
    for name in only:
        if name not in problems:
            raise InputError.not_in("--only", name, problems)
    path = Path(folder) / TABLE
    rows = [row for row in (models.read(path) if only and path.exists() else []) if row.problem not in only]
    for name in counted(only or list(problems), "models", "problems"):
        rows += measured(problems[name], quick, say)
        write(rows, path)
    return [path, *report(rows, folder)]


def write(rows, path):
    """Table of `Row`s as CSV; -> its path."""
    return write_table(path, list(COLUMNS), [
        [row.problem, row.question, row.rung, *(f"{vars(row)[name]:.6g}" for name in COLUMNS[3:-1]),
         "yes" if row.yes_no else "no"] for row in rows])


def measured(problem, quick, say):
    """`Row`s of a problem: of every rung that takes no longer than the problem allows, and of the finest."""
    scene = load_scene(problem.scene, dict(problem.changes))
    asks = {name: Ask.of(scene, name, problem.at if name == "peak-pressure" else None,
                         problem.obstacle if name == "load" else None) for name in problem.questions}
    first = next(iter(asks.values()))
    ladder = ladder_of(scene, first)
    most = min(problem.most, QUICK) if quick else problem.most
    found = {}
    for step in ladder.steps:
        if step.seconds > most and (quick or step.name != problem.finest):
            continue
        try:
            found[step.name] = *answered(scene, asks, step), step
        except (SimulationError, InputError) as error:
            say(f"{problem.name}, {step.name}: {str(error).splitlines()[0]}")
            continue
        values, seconds, _ = found[step.name]
        said = ", ".join(f"{name} {value:.5g}" for name, value in values.items() if value is not None)
        say(f"{problem.name:24s} {step.name:24s} {seconds:8.1f} s ({step.seconds:.1f})  {said or 'no answer'}")
    return list(_rows(problem, found))


def answered(scene, asks, step):
    """({question: value}, processor seconds of the whole command) of a rung."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        if step.rung.changes is not None and not step.rung.trials:
            write_text(folder / "scene.toml", with_overrides(scene, step.rung.changes).to_toml())
            seconds = spent(["run", folder / "scene.toml", "-o", folder / "run", "--accept-cost", "--quiet"])
            run = Run(folder / "run")
            return {question: answer_of(run, ask) for question, ask in asks.items()}, seconds
        write_text(folder / "scene.toml", scene.to_toml())
        values, each, refused = dict.fromkeys(asks), [], None
        for question, ask in asks.items():
            place = [] if ask.place is None else ["--at", ",".join(map(str, ask.place))]
            try:
                each.append(spent(["run", folder / "scene.toml", "--question", question, "--rung", step.name, *place,
                                   "-o", folder / question]))
            except SimulationError as error:  # a formula answers some of the questions
                refused = error
                continue
            record = json.loads((folder / question / climb.ANSWER).read_text(encoding="utf-8"))
            values[question] = record["rungs"][0]["value"]
        if not each:
            raise refused
        return values, min(each)


def spent(words):
    """Processor seconds of a command of this program on one thread. Raises SimulationError where it fails."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run([sys.executable, "-m", "snowmpm", *map(str, words), "--threads", "1"], capture_output=True,
                          text=True, check=False)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    if done.returncode:
        raise SimulationError(done.stderr.strip().splitlines()[-1] if done.stderr.strip() else "failed")
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def _rows(problem, found):
    """`Row`s of the answers of a problem. found: {rung: (answers, seconds, step)}."""
    for name, known in problem.questions.items():
        answers = {rung: values.get(name) for rung, (values, _, _) in found.items()}
        reference = known.value if isinstance(known, Known) else answers.get(problem.finest)
        if reference is None or (reference <= 0.0 and not QUESTIONS[name].yes_no):
            continue
        if isinstance(known, Known):
            unsure = known.unsure
        else:
            unsure = known or (0.0 if QUESTIONS[name].yes_no else _unsure(problem, answers))
        for rung, value in answers.items():
            if value is not None:
                _, seconds, step = found[rung]
                yield Row(problem.name, name, rung, value, reference, unsure, seconds, step.seconds,
                          QUESTIONS[name].yes_no)


def _unsure(problem, answers):
    """To what share the answer of the finest rung is known: by how much the next coarser one of its kind differs.
    Raises InputError where there is none: the problem must say it."""
    last, (kind, _, cells) = answers.get(problem.finest), problem.finest.rpartition(", ")
    coarser = [(float(rung.rpartition(", ")[2].split()[0]), value) for rung, value in answers.items()
               if value and rung.rpartition(", ")[0] == kind]
    before = [one for one in coarser if one[0] < float(cells.split()[0])]
    if not last or not before:
        raise InputError(f"{problem.name}: no rung below {problem.finest} tells to what its answer is known")
    return abs(max(before)[1] / last - 1.0)


def report(rows, folder):
    """Charts of a table of rows; -> paths."""
    from snowmpm.ladder.charts import chart

    asked = [name for name in QUESTIONS if any(row.question == name for row in rows)]
    return [*(chart(name, [row for row in rows if row.question == name], Path(folder) / f"models_{name}.png")
              for name in asked),
            write_text(Path(folder) / "models.md", "\n\n".join(filter(None, (page_of(name, rows) for name in asked))))]


def page_of(question, rows):
    """Markdown table of what each rung was measured to miss of the answer to a question, cheap to dear; those that
    nothing beats are bold, and those that tell nothing are named below it. Empty where none is known."""
    groups = {}
    for row in rows:
        if row.question == question:
            groups.setdefault(row.rung, []).append(row)
    lines, off, best = [], [], float("inf")
    typical = {rung: float(np.median([row.seconds for row in own])) for rung, own in groups.items()}
    for rung in sorted(groups, key=typical.get):
        expected = models.expected_of(groups[rung])
        if expected is None:
            continue
        if not expected.tells:
            off.append(rung)
            continue
        star = "**" if expected.error < best else ""
        best = min(best, expected.error)
        lines.append(f"| {star}{rung}{star} | {typical[rung]:.0f} | {expected.words} | {expected.n} |")
    if not lines and not off:
        return ""
    rest = [f"\nMay be off by a factor of two and more, or wrong in a third of cases: {'; '.join(off)}."] if off else []
    return "\n".join([f"| {QUESTIONS[question].label} | seconds | error | problems |", "|---|---|---|---|", *lines,
                      *rest])

