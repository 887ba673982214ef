"""The choice of a model on scenes of which no error was measured: does the answer lie where it was promised?

    SNOWMPM_EVENTS=FOLDER python tests/benchmarks/model_choices.py [--only WORD ...]

Each scene is asked one question. `snowmpm choose` picks a rung by the shipped table of errors; it runs, and so does the
finest rung that is named here, both on one thread, as whole commands. Writes model_choices.csv: the interval of
relative errors that was promised, the error against the finest rung, the processor seconds of both. SNOWMPM_EVENTS:
folder with the files of observed avalanches (`snowmpm docs events`).
"""

import argparse
import csv
from dataclasses import dataclass, field
from pathlib import Path

from snowmpm.compiler import runtime
from snowmpm.ladder.ladder import choose, ladder_of
from snowmpm.ladder.questions import Ask
from snowmpm.ladder.study import answered
from snowmpm.scenes import load_scene

FILE = Path(__file__).parent / "figures" / "model_choices.csv"
COLUMNS = ("scene", "question", "within", "rung", "low", "high", "value", "seconds", "finest", "finest_value",
           "finest_seconds", "error", "inside", "share_of_time")


@dataclass(frozen=True)
class Unseen:
    """name; scene; question; within: the error that will do; finest: rung that is taken for the truth."""

    name: str
    scene: str
    question: str
    within: float
    finest: str
    changes: dict = field(default_factory=dict)


UNSEEN = (
    Unseen("Arzler Alm 2019", "event:arzler_alm_2019", "run-out", 0.25, "3-D mpm, 1 cell"),
    Unseen("Nordkette 2022", "event:nordkette_2022", "run-out", 0.25, "3-D mpm, 1 cell"),
    Unseen("moist snow in profile", "flow_warm_shear", "run-out", 0.55, "mpm, 32 cells"),
    Unseen("flat saw test on a thin slab", "pst_2d", "critical-length", 0.5, "resolved, 40 cells",
           {"saw_test.slab.0.thickness": 0.35, "materials.slab.density": 300.0}),
    Unseen("saw test down 20 degrees", "pst_2d", "critical-length", 0.5, "resolved, 40 cells",
           {"saw_test.slope_angle": -20.0}),
    Unseen("crack on 15 degrees", "pst_2d", "crack-speed", 0.75, "resolved, 40 cells", {"saw_test.slope_angle": 15.0}),
    Unseen("faster flow on a wall", "impact_wall_2d", "load", 0.4, "mpm, 32 cells",
           {"terrain.points": [[0.0, 24.0], [26.0, 1.8], [36.0, 1.8]]}),
    Unseen("cut in clay", "slope_failure", "factor-of-safety", 0.25, "reduction, 40 cells",
           {"materials.soil.friction_angle": 10.0, "materials.soil.cohesion": 1.2e4}),
)


def row_of(one):
    scene = load_scene(one.scene, dict(one.changes))
    ask = Ask.of(scene, one.question)
    ladder = ladder_of(scene, ask)
    chosen, _ = choose(ladder.steps, one.within)
    found = {}
    for step in dict.fromkeys((chosen.name, one.finest)):
        values, seconds = answered(scene, {one.question: ask}, ladder.step(step))
        found[step] = values[one.question], seconds
    value, seconds = found[chosen.name]
    finest, longest = found[one.finest]
    error = value / finest - 1.0
    return dict(zip(COLUMNS, (
        one.name, one.question, one.within, chosen.name, chosen.expected.low, chosen.expected.high, value, seconds,
        one.finest, finest, longest, error,
        "yes" if chosen.expected.low <= error <= chosen.expected.high else "no", seconds / longest), strict=True))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", nargs="*", default=[])
    wanted = parser.parse_args().only
    runtime.start("cpu", 1)
    kept = []
    if wanted and FILE.exists():
        with FILE.open(encoding="utf-8", newline="") as file:
            kept = list(csv.DictReader(file))
    for one in UNSEEN:
        if wanted and not any(word in one.name for word in wanted):
            continue
        row = {name: f"{value:.4g}" if isinstance(value, float) else value for name, value in row_of(one).items()}
        print(", ".join(f"{name} {value}" for name, value in row.items()), flush=True)
        names = [unseen.name for unseen in UNSEEN]
        kept = sorted([*(old for old in kept if old["scene"] != row["scene"]), row],
                      key=lambda one: names.index(one["scene"]))
        with FILE.open("w", encoding="utf-8", newline="") as file:
            writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
            writer.writeheader()
            writer.writerows(kept)


if __name__ == "__main__":
    main()
