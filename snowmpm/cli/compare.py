"""`snowmpm compare`: runs over each other, and over what is known of their scene."""

import math
from pathlib import Path
from typing import Annotated

import typer

from snowmpm.cli.table import print_facts
from snowmpm.cli.wording import count, duration
from snowmpm.errors import InputError

Runs = Annotated[list[str], typer.Argument(metavar="RUN RUN ...", help="Folders of runs, or their run.vtkhdf files.")]
Output = Annotated[
    Path, typer.Option("-o", "--output", metavar="FILE", help="Where the picture goes: .png, .pdf or .svg.")
]
Moment = Annotated[
    float | None, typer.Option("--time", metavar="T", help="Moment of profiles and stresses, in s; the end by default.")
]
LineText = Annotated[
    str | None,
    typer.Option("--line", metavar="AXIS=M", help="Line of the stresses: x=0.2 upright, z=0.1 level; x in the middle of"
                                                  " the mass by default."),
]
MOST_RUNS = 12


def compare(runs: Runs, output: Output = Path("compare.png"), time: Moment = None, line: LineText = None):
    """Lay runs over each other: profile, front, energies, stress along a line, cost; and against what is known.

    MPM and SPH, two resolutions, two laws: any runs of the same dimension. A scene with a table [reference] names what
    is known of it, an experiment or a formula: measured numbers then stand beside those.
    """
    from snowmpm.comparison import open_cases
    from snowmpm.render import render_comparison
    from snowmpm.render.figure import check_ending

    check_ending(output)
    if not 2 <= len(runs) <= MOST_RUNS:
        raise InputError(f"{len(runs)} run{'s' * (len(runs) != 1)} to compare: name 2 to {MOST_RUNS}")
    cases = open_cases(runs)
    found = [Found(case, time, line) for case in cases]
    _print_table(found)
    written = render_comparison(_drawing(found), output)
    for name, facts in _known(found).items():
        print_facts(name, facts)
    print(written)


class Found:
    """What is drawn and printed of one run: profile and stresses at a moment, answers at the end."""

    def __init__(self, case, time, line):
        from snowmpm.comparison import Line, profile, stress_along
        from snowmpm.comparison.answers import answer_of

        self.case, run = case, case.run
        self.answer = answer_of(case)
        self.frame_number = len(run) - 1 if time is None else case.frame_at(time)
        if time is not None and not 0.0 <= time <= run.times[-1] * (1.0 + 1e-9):
            raise InputError(f"--time {time:g}: {run.path} goes from 0 to {run.times[-1]:g} s")
        first, frame = run.frame(0), run.frame(self.frame_number)
        centre = self.answer.centre() if self.answer else None
        self.first, self.profile = profile(case, first, centre), profile(case, frame, centre)
        middle = round(float(case.positions(first)[:, 0].mean()), 6) + 0.0  # no minus in front of a zero
        self.line = Line.of(line) if line else Line("x", middle)
        self.stress = stress_along(case, frame, self.line)
        self.quantities = self.answer.quantities() if self.answer and run.complete else []
        self.curve = self.answer.history() if self.answer and run.complete else None

    @property
    def moment(self):
        return float(self.case.run.times[self.frame_number])


def _rows(found):
    """(name, texts of each run, numbers of each run or None): what the table says."""
    from snowmpm.comparison.difference import profile_difference

    histories = [one.case.run.history for one in found]

    def last(name):
        return [float(history[name][-1]) if name in history else math.nan for history in histories]

    def largest(name):
        return [max((float(v) for v in history[name] if v == v), default=math.nan) if name in history else math.nan
                for history in histories]

    cases = [one.case for one in found]
    particles = [int(history["particles"][0]) if "particles" in history else case.run.n_points(0)
                 for history, case in zip(histories, cases, strict=True)]
    yield "method", [case.method for case in cases], None
    yield "dx [m]", [f"{case.dx:g}" for case in cases], None
    yield "particle spacing [m]", [f"{case.spacing:.3g}" for case in cases], None
    yield "numerical damping", [case.damping for case in cases], None
    yield "particles", [count(n) for n in particles], None
    yield "steps", [count(case.steps) for case in cases], None
    yield "wall time", [duration(case.wall_time) if math.isfinite(case.wall_time) else "-" for case in cases], None
    cost = [case.run.summary.get("ns_per_particle_step") for case in cases]
    yield "ns per particle and step", ["-" if ns is None else f"{ns:.0f}" for ns in cost], None
    yield "simulated [s]", [f"{case.run.times[-1]:g}" for case in cases], None
    for name, values in (("front of 99.5 % of what moved [m]", last("front")),
                         ("largest speed [m/s]", largest("max_speed")),
                         ("largest kinetic energy [J]", largest("kinetic_energy")),
                         ("plastic work [J]", last("plastic_work"))):
        yield name, [f"{value:.4g}" for value in values], values
    ends = [one.profile.front for one in found], [float(one.profile.top.max()) for one in found]
    yield "end of the profile [m]", [f"{value:.4g}" for value in ends[0]], ends[0]
    yield "highest of the profile [m]", [f"{value:.4g}" for value in ends[1]], ends[1]
    apart = [profile_difference(found[0].profile, one.profile) for one in found]
    yield "profile apart, of its depth", ["", *(f"{100.0 * value:.2g} %" for value in apart[1:])], None
    yield "momentum residual", [f"{value:.1e}" for value in last("momentum_residual")], None


def _print_table(found):
    from rich.console import Console
    from rich.table import Table

    table = Table(box=None, pad_edge=False, header_style="bold")
    table.add_column("")
    for one in found:
        table.add_column(one.case.label, justify="right")
    for name, texts, numbers in _rows(found):
        table.add_row(name, *(_beside(text, numbers, i) for i, text in enumerate(texts)))
    for name, unit, entries in _quantities(found):
        known = next(entry for entry in entries if entry)
        band = f"{known.low:.4g}" if known.low == known.high else f"{known.low:.4g} to {known.high:.4g}"
        texts = ["-" if entry is None else f"{entry.measured:.4g} ({100.0 * entry.error:+.1f} %)" for entry in entries]
        table.add_row(f"{name} [{unit}], known {band}", *texts, style="bold")
    # A pipe has no width of its own: nothing is folded there
    console = Console(highlight=False, markup=False)
    if not console.is_terminal:
        console = Console(highlight=False, markup=False, width=200)
    console.print(table)


def _beside(text, numbers, i):
    """The text, and how far its number is from the first run's."""
    if numbers is None or i == 0 or not math.isfinite(numbers[i]) or not numbers[0]:
        return text
    return f"{text} ({100.0 * (numbers[i] / numbers[0] - 1.0):+.1f} %)"


def _quantities(found):
    """(name, unit, [`Quantity` or None of each run])"""
    named = {(q.name, q.unit): None for one in found for q in one.quantities}
    for name, unit in named:
        yield name, unit, [next((q for q in one.quantities if q.name == name), None) for one in found]


def _known(found):
    """What the scenes' answers say, by title; the same of several runs once."""
    known = {}
    for one in found:
        if one.answer:
            facts = {"source": one.answer.SOURCE, **one.answer.facts()}
            if facts not in known.values():
                known[f"what is known of {one.case.scene['name']} ({one.case.label})"] = facts
    return known


def _drawing(found):
    from snowmpm.comparison.profile import ALONG
    from snowmpm.render import ComparedRun, Comparison

    runs = []
    for one in found:
        line = {name: (one.stress.place, values) for name, values in one.stress.values.items()} if one.stress else {}
        measured = (one.curve.x, one.curve.y) if one.curve else None
        runs.append(ComparedRun(one.case.label, one.profile.outline, one.first.outline, line,
                                one.case.run.history, measured))
    names = dict.fromkeys(one.case.scene["name"].replace("_", " ") for one in found)
    curve = next((one.curve for one in found if one.curve), None)
    return Comparison(
        title=" and ".join(names), runs=runs, along=ALONG[found[0].profile.along], line=str(found[0].line),
        moment=found[0].moment, width=found[0].case.run.dimension == 2,
        known_profile=next((one.answer.profile() for one in found if one.answer), None),
        curve=(curve.x_label, curve.y_label, curve.known_x, curve.known_y) if curve else None,
        numbers=[(name, unit, first.low, first.high, [q.measured for q in entries if q])
                 for name, unit, entries in _quantities(found) for first in [next(q for q in entries if q)]])
