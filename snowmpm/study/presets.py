"""What `snowmpm run --fast` and `--accurate` change, measured: error and time of moves along the Pareto front.

Every problem is solved on its usual grid as the program would, and again after each move: a coarser or finer grid, with
other splines and particles. The table of the package (`data/presets.csv`), from which the commands choose and
whose numbers they print, is what this study writes; the page says which moves they choose and what they give.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from snowmpm.draft import write_text
from snowmpm.errors import InputError, SimulationError
from snowmpm.stages import counted
from snowmpm.study.measurement import measure, read, write
from snowmpm.study.pareto import merged, noise
from snowmpm.study.problems.catalogue import CATALOGUE
from snowmpm.study.variation import BY_NAME, DEFAULT, Variation

DATA = Path(__file__).with_name("data") / "presets.csv"
LEFT_OUT = ("waves", "fresh", "energy_line", "anticrack")
"""Its grid must be of whole blocks; a front without a length of its own; two cells, which no grid a little coarser has;
a crack that not every grid lets run."""
PROBLEMS = tuple(name for name in CATALOGUE if name not in LEFT_OUT)
FASTER, LESS_ERROR = 3.0, 0.5
"""What --fast and --accurate promise: times the speed, share of the error."""
MARGIN = 1.15
"""So much more is expected of a move than is promised: expected times are those of another machine."""


@dataclass(frozen=True)
class Move:
    """A step along the front: coarser: factor of dx; variation: what else is changed."""

    coarser: float
    variation: Variation

    @property
    def name(self):
        return f"{self.coarser:g} dx, {self.variation.name}"

CUBIC = BY_NAME["cubic"]
MOVES = (
    *(Move(coarser, DEFAULT) for coarser in (1.25, 1.35, 1.5, 2.0)), *(Move(coarser, CUBIC) for coarser in (1.5, 2.0)),
    Move(1.0, CUBIC), Move(1.0, BY_NAME["3 per axis"]), *(Move(0.7, variation) for variation in (DEFAULT, CUBIC)),
    Move(0.5, DEFAULT),
)


def study(folder, *, quick=False, only=(), say=print):
    """Measure the moves, or with `only` those problems and keep the table's other rows; -> paths."""
    for name in only:
        if name not in PROBLEMS:
            raise InputError.at("--only", name, f"must be a problem: {', '.join(PROBLEMS)}")
    path = Path(folder) / DATA.name
    names = only or PROBLEMS
    rows = [row for row in read(path) if row.problem not in names] if only and path.exists() else []
    for name in counted(names, "presets", "problems"):
        for row in moved(CATALOGUE[name], quick, say):
            rows.append(row)
        write(rows, path)
    return [path, write_text(Path(folder) / "presets.md", "\n".join(report(rows)) + "\n")]


def moved(problem, quick, say):
    """Rows of one problem: the program's own choice, repeated, then every move that it can be solved after."""
    usual = problem.quick[-1] if quick and problem.quick else problem.usual
    plan = [(DEFAULT, usual)] * (1 if quick else 3)
    plan += [(_named(move), max(2, round(usual / move.coarser))) for move in MOVES]
    for variation, cells in plan:
        try:
            row = measure(problem, variation, cells)
        except SimulationError as error:
            say(f"{problem.name}, {variation.name}: failed: {str(error).splitlines()[0]}")
            continue
        if not np.isfinite(row.error):
            say(f"{problem.name}, {variation.name}: no answer")
            continue
        say(f"{problem.name:12s} {variation.name:30s} {cells:4d} cells {row.seconds:8.2f} s  error {row.error:.2e}")
        yield row


def _named(move):
    variation = move.variation
    return Variation(move.name, variation.group, variation.scheme, variation.per_axis)


@dataclass(frozen=True)
class Gain:
    """A move over the program's own choice, problem by problem: ratios of error, particle-steps and time (n,)."""

    move: Move
    error: np.ndarray
    work: np.ndarray
    seconds: np.ndarray

    @property
    def typical(self):
        return float(np.median(self.error))

def gains(rows):
    """`Gain` of every move that all problems of the table were solved after."""
    rows = merged(rows)
    own = {row.problem: row for row in rows if row.variation == DEFAULT.name}
    found = []
    for move in MOVES:
        after = {row.problem: row for row in rows if row.variation == move.name}
        if own and after.keys() == own.keys():
            ratios = [[after[name][size] / own[name][size] for name in own]
                      for size in ("error", "particle_steps", "seconds")]
            found.append(Gain(move, *np.array(ratios)))
    return found


def fastest(table, saving):
    """The move that costs least accuracy among those that are FASTER; saving(move): time over the program's of a scene.
    Of a move that is not fast enough anywhere the fastest."""
    enough = [gain for gain in table if saving(gain.move) <= 1.0 / (FASTER * MARGIN)]
    return min(enough, key=lambda gain: gain.typical) if enough else min(table, key=lambda gain: saving(gain.move))


def most_accurate(table, saving):
    """The cheapest move whose typical error is LESS_ERROR of the program's."""
    enough = [gain for gain in table if gain.typical <= LESS_ERROR]
    if not enough:
        return min(table, key=lambda gain: gain.typical)
    return min(enough, key=lambda gain: saving(gain.move))


def report(rows):
    """Markdown lines: every move, typical and worst."""
    times, _ = noise(rows)
    lines = ["# What --fast and --accurate choose from", "",
             f"Over the program's own choice on the usual grid, median (range) of {len(_problems(rows))} problems in"
             f" plane strain; repeated times differ by {times:.0%} at most.", "",
             "| move | error | particle-steps | time |", "|---|---|---|---|"]
    for gain in sorted(gains(rows), key=lambda gain: np.median(gain.work)):
        lines.append(f"| {gain.move.name} | " + " | ".join(in_words(values) for values in (
            gain.error, gain.work, gain.seconds)) + " |")
    return lines


def in_words(ratios):
    """Median (least to largest)."""
    return f"{np.median(ratios):.2g} ({ratios.min():.2g} to {ratios.max():.2g})"


def _problems(rows):
    return {row.problem for row in rows}
