"""`snowmpm compare`: runs beside each other, and beside the reference of their scene."""

import math
import sys
from pathlib import Path
from typing import Annotated

import typer

from snowmpm.cli.table import print_definitions, print_facts
from snowmpm.cli.wording import count, duration
from snowmpm.errors import InputError, shown_line
from snowmpm.stages import counted, stage

Runs = Annotated[list[str], typer.Argument(metavar="RUN RUN ...", help="Folders of runs, or their run.vtkhdf files.")]
Output = Annotated[
    Path, typer.Option("-o", "--output", metavar="FILE", help="File of the picture: .png, .pdf or .svg.")
]
Moment = Annotated[
    float | None, typer.Option("--time", metavar="T", help="Time of profiles and stresses, in s; the end by default.")
]
LineText = Annotated[
    str | None,
    typer.Option("--line", metavar="AXIS=M", help="Line of the stresses: x=0.2 vertical, z=0.1 horizontal; the vertical"
                                                  " through the centre of mass by default."),
]


def _definitions(wanted: bool):
    if wanted:
        from snowmpm.quantities.saw import SAW_TEST

        print_definitions({"saw test: names in a campaign's table; without saw_ in compare and summary.json": SAW_TEST})
        raise typer.Exit


Definitions = Annotated[
    bool, typer.Option("--definitions", callback=_definitions, is_eager=True, help="Say what each number of a saw test"
                                                                                   " means.")
]
MOST_RUNS = 12
COMPARED = ("runout", "reach_of_flow", "travel_angle", "affected_area", "area_above_1_kPa", "area_above_10_kPa",
            "largest_flow_speed", "largest_flow_pressure", "deposit_volume")
"""Numbers of hazard mapping in the table."""


def compare(runs: Runs, output: Output = Path("compare.png"), time: Moment = None, line: LineText = None,
            definitions: Definitions = False):
    """Compare runs with each other and with a reference: profile, front, energies, stress along a line, cost.

    The runs may differ in method, resolution or law, but must have the same dimension. The table [reference] of a scene
    names its reference, an experiment or a formula; results are then printed beside it. For saw tests, the command
    compares critical length, crack speed, collapse height and energies, each beside theory. With --time or --line, saw
    tests are compared like other runs.
    """
    from snowmpm.comparison import open_cases
    from snowmpm.render import render_comparison
    from snowmpm.render.figure import check_ending

    check_ending(output)
    if not 2 <= len(runs) <= MOST_RUNS:
        raise InputError(f"{len(runs)} run{'s' * (len(runs) != 1)} to compare: name 2 to {MOST_RUNS}")
    cases = open_cases(runs)
    if all(case.run.saw_test for case in cases) and time is None and line is None:
        with stage("drawing"):
            written = _compare_saw_tests(cases, output)
        print(written)
        return
    way, apart = _way(cases), _apart(cases)
    found = [Found(case, time, line, None if apart else way, placed=not apart)
             for case in counted(cases, "measuring", "runs")]
    lost = [one.case.label for one in found if not apart and (one.first is None or one.profile is None)]
    _print_table(found)
    _warn_of_lost_mass(cases)
    for name, facts in _known(found).items():
        print_facts(name, facts)
    if apart or lost:
        why = apart or (f"{', '.join(shown_line(label, 60) for label in lost)}: too little snow on the thalweg of the"
                        " first run, the runs went different ways")
        print(f"warning: {why}: profiles, fronts and stresses are not compared, and no picture is drawn",
              file=sys.stderr)
        return
    with stage("drawing"):
        written = render_comparison(_drawing(found), output)
    print(written)


def _compare_saw_tests(cases, output):
    """Print the table of saw tests and remarks where measurement and theory differ much; draw the figure; -> its
    path."""
    from snowmpm.cli.compare_saw_tests import remarks_of, saw_test_rows
    from snowmpm.render import ComparedSawTest, render_saw_tests
    from snowmpm.saw_test.theories import further_theories

    tests = [ComparedSawTest(case.label, case.run, further_theories(case.run)) for case in cases]
    _print_rows([case.label for case in cases], [*_set_up_rows(cases), *saw_test_rows(tests)])
    for line in remarks_of(tests):
        print(line)
    return render_saw_tests(tests, output)


def _way(cases):
    """The thalweg of the first run if all runs are on real terrain, else None."""
    from snowmpm.comparison import Way

    way = Way.of(cases[0].run)
    return way if way is not None and all(case.run.hazard.get("profile") for case in cases) else None


def _apart(cases):
    """Why places of the runs cannot be compared: they have several coordinate systems; "" where they can."""
    from snowmpm.io.projection import projection_name

    systems = {case.label: projection_name(case.run.provenance.get("crs")) for case in cases
               if case.run.provenance.get("crs")}
    if len(set(systems.values())) < 2:
        return ""
    named = "; ".join(f"{shown_line(label, 60)}: {name}" for label, name in systems.items())
    return f"the coordinate systems differ ({named})"


def _warn_of_lost_mass(cases):
    """Warn of runs that lost mass: none of their numbers includes it."""
    from snowmpm.io.status import LEFT_SHARE, status_of
    from snowmpm.quantities.quantity import written

    for case in cases:
        left = status_of(case.run).left_share
        if left > LEFT_SHARE:
            print(f"warning: {shown_line(case.label, 60)}: {written(left, 'share')} of the mass left the model, and is"
                  " in no front, profile, run-out or deposit: a larger terrain or domain compares", file=sys.stderr)


class Found:
    """What is drawn and printed of one run: profile and stresses at one time, reference quantities at the end."""

    def __init__(self, case, time, line, way=None, placed=True):
        """placed: whether places of the runs may be compared; else it has no profile and no stresses."""
        from snowmpm.comparison import Line, profile, stress_along
        from snowmpm.comparison.answers import answer_of

        self.case, run = case, case.run
        self.answer = answer_of(case)
        self.frame_number = len(run) - 1 if time is None else case.frame_at(time)
        if time is not None and not 0.0 <= time <= run.times[-1] * (1.0 + 1e-9):
            raise InputError(f"--time {time:g}: {run.path} goes from 0 to {run.times[-1]:g} s")
        first, frame = run.frame(0), run.frame(self.frame_number)
        centre = self.answer.centre() if self.answer else None
        way = way if centre is None else None
        self.first, self.profile = (profile(case, one, centre, way) if placed else None for one in (first, frame))
        middle = round(float(case.positions(first)[:, 0].mean()), 6) + 0.0  # avoids -0.0
        self.line = Line.of(line) if line else Line("x", middle)
        self.stress = stress_along(case, frame, self.line) if placed else None
        self.quantities = self.answer.quantities() if self.answer and run.complete else []
        self.curve = self.answer.history() if self.answer and run.complete else None

    @property
    def moment(self):
        return float(self.case.run.times[self.frame_number])


def _rows(found):
    """Rows of the table: (name, texts of each run, numbers of each run or None)."""
    from snowmpm.io.published import resolution_of
    from snowmpm.io.status import cautions, status_of
    from snowmpm.quantities.resolution import rounded
    from snowmpm.quantities.table import NUMBERS, quantity

    cases = [one.case for one in found]
    histories = [case.run.history for case in cases]

    def last(name):
        return [float(history[name][-1]) if name in history else math.nan for history in histories]

    def largest(name):
        return [max((float(v) for v in history[name] if v == v), default=math.nan) if name in history else math.nan
                for history in histories]

    yield from _set_up_rows(cases)
    # The front of the history is measured along a straight line. On real terrain run-out and reach are shown instead.
    placed = all(one.first is not None and one.profile is not None for one in found)
    straight = [("front", "", last("front"))] if placed and found[0].profile.along != "s" else []
    for name, words, values in (*straight, ("max_speed", ", at most in a frame", largest("max_speed")),
                                ("kinetic_energy", ", at most in a frame", largest("kinetic_energy")),
                                ("plastic_work", "", last("plastic_work"))):
        if not all(map(math.isnan, values)):
            one = quantity(name, dimension=cases[0].run.dimension)
            yield one.label + words, [one.text(value) for value in values], values
    known = [resolution_of(case.run) for case in cases]
    for one in NUMBERS:
        values = [case.run.hazard.get("numbers", {}).get(one.name, math.nan) for case in cases]
        if one.name in COMPARED and any(map(math.isfinite, values)):
            texts = [one.text(rounded(value, own.get(one.name)), own.get(one.name))
                     for value, own in zip(values, known, strict=True)]
            yield one.label, texts, values
    yield "status", [status_of(case.run).short if cautions(case.run) else "final" for case in cases], None
    if placed:
        yield from _profile_rows(found)
    yield "momentum residual", [f"{value:.1e}" for value in last("momentum_residual")], None


def _profile_rows(found):
    """Rows of the profiles, which all runs have."""
    from snowmpm.comparison.difference import profile_difference
    from snowmpm.quantities.quantity import written

    ends, tops = [one.profile.front for one in found], [float(one.profile.top.max()) for one in found]
    # Differences are relative to a distance and a height, not to coordinates, whose origin is arbitrary
    back, low = found[0].first.back, float(found[0].first.bottom.min())
    if found[0].profile.along == "s":
        back = low = 0.0
    yield "end of the profile", [written(value, "m") for value in ends], [value - back for value in ends]
    yield "highest of the profile", [written(value, "m") for value in tops], [value - low for value in tops]
    apart = [profile_difference(found[0].profile, one.profile) for one in found]
    yield "profile apart, of its depth", ["", *(f"{100.0 * value:.2g} %" for value in apart[1:])], None


def _set_up_rows(cases):
    """Settings and cost of each run."""
    particles = [int(case.run.history["particles"][0]) if "particles" in case.run.history else case.run.n_points(0)
                 for case in cases]
    from snowmpm.io.parameters import methods_of

    yield "method", [" -> ".join(row["method"] for row in methods_of(case.run)) or case.method for case in cases], None
    yield "dx [m]", [f"{case.dx:g}" for case in cases], None
    yield "particle spacing [m]", [f"{case.spacing:.3g}" for case in cases], None
    yield "numerical damping", [case.damping for case in cases], None
    yield "particles", [count(n) for n in particles], None
    yield "steps", [count(case.steps) for case in cases], None
    yield "wall time", [duration(case.wall_time) if math.isfinite(case.wall_time) else "-" for case in cases], None
    cost = [case.run.summary.get("ns_per_particle_step") for case in cases]
    yield "ns per particle and step", ["-" if ns is None else f"{ns:.0f}" for ns in cost], None
    yield "simulated [s]", [f"{case.run.times[-1]:g}" for case in cases], None


def _print_table(found):
    known_rows = []
    for name, unit, entries in _quantities(found):
        known = next(entry for entry in entries if entry)
        band = f"{known.low:.4g}" if known.low == known.high else f"{known.low:.4g} to {known.high:.4g}"
        texts = ["-" if entry is None else f"{entry.measured:.4g} ({100.0 * entry.error:+.1f} %)" for entry in entries]
        known_rows.append([f"{name} [{unit}], known {band}", *texts])
    _print_rows([one.case.label for one in found], _rows(found), known_rows)


def _print_rows(labels, rows, known_rows=()):
    """Print a table with one column a run. rows: (name, texts, numbers or None); known_rows: lists of texts, in
    bold."""
    from rich.console import Console
    from rich.table import Table

    table = Table(box=None, pad_edge=False, header_style="bold")
    table.add_column("")
    for label in labels:
        table.add_column(shown_line(label, 60), justify="right")
    for name, texts, numbers in rows:
        table.add_row(name, *(_beside(text, numbers, i) for i, text in enumerate(texts)))
    for texts in known_rows:
        table.add_row(*texts, style="bold")
    # A pipe has no width: lines are not wrapped there
    console = Console(highlight=False, markup=False)
    if not console.is_terminal:
        console = Console(highlight=False, markup=False, width=200)
    console.print(table)


def _beside(text, numbers, i):
    """The text, with the relative difference of its number from the first run's."""
    if numbers is None or i == 0 or not math.isfinite(numbers[i]) or not numbers[0]:
        return text
    return f"{text} ({100.0 * (numbers[i] / numbers[0] - 1.0):+.1f} %)"


def _quantities(found):
    """(name, unit, [`Quantity` or None of each run])"""
    named = {(q.name, q.unit): None for one in found for q in one.quantities}
    for name, unit in named:
        yield name, unit, [next((q for q in one.quantities if q.name == name), None) for one in found]


def _known(found):
    """Reference facts of the scenes by title; facts common to several runs appear once."""
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
