"""Runs of scenes that were measured, and what `snowmpm check` says of them.

`scene_runs.csv` holds processor times of the first part of each run, by stage (tests/benchmarks/scene_runs.py); the
forecast is of the same part. Its times are brought to the speed of the machine that the costs are for by the speed that
was sampled while they ran; 18 rows, measured before it was sampled, carry the mean of their day.
"""

import csv
import functools
from pathlib import Path

from snowmpm import load_scene
from snowmpm.advice.budget import Budget
from snowmpm.advice.facts import SceneFacts
from snowmpm.measured import costs
from snowmpm.setup.build import build

ROOT = Path(__file__).parents[2]
WARM_UP = 3
"""First steps of a run in the table, which count as start there."""
STEPPING = ("scatter", "grid", "contact", "gather", "sort", "rest")


@functools.cache
def rows():
    """All rows of the table."""
    with open(ROOT / "snowmpm" / "measured" / "scene_runs.csv", newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


@functools.cache
def budget_of(name, settings=()):
    """`made` of settings (key, value), kept."""
    return made(name, dict(settings))


def made(name, overrides):
    """`Budget` of a scene of the library, or of a file in the repository."""
    scene = load_scene(str(ROOT / name) if name.endswith(".toml") else name, overrides)
    model = build(scene)
    return Budget(SceneFacts(scene, model, model.solver()))


def forecast(budget, row):
    """Seconds of the part of a run that a row of the table is of, its start left out. Who can say when a state has
    settled? Of settling steps only the cost is foretold here, not the number."""
    steps = budget.facts.steps_until(float(row["part"]))
    settling = float(row["settling_steps"]) * sum(budget.stages(settling=True).values())
    return settling + steps * budget.step() + float(row["frames"]) / budget.frames * budget.output


def measured(row):
    """The same as measured, on a machine of the speed that the costs are for. Seconds."""
    seconds = sum(float(row[stage]) for stage in (*STEPPING, "settling", "output"))
    steps = float(row["steps"]) + float(row["settling_steps"])
    more = (steps + WARM_UP) / steps  # the first steps count as start there
    return more * seconds * costs.reference_speed()[0] / float(row["vector"])
