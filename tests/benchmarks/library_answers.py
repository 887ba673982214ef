"""What each scene of the library tells, and how far that is from what finer cells tell: is it on the right grid?

    python tests/benchmarks/library_answers.py [--only SCENE ...] [--grids wider own finer]

Each scene runs on cells twice as wide as its own, on its own, and on finer ones, as whole commands on one thread.
Writes library_answers.csv: the answer and the processor seconds of each. The header of a scene states its answer and
to what it is known; tests/scenes/test_what_the_library_tells.py holds it against the table.
"""

import argparse
import csv
import tempfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from snowmpm.comparison import Case
from snowmpm.comparison.answers import answer_of as reference_of
from snowmpm.draft import write_text
from snowmpm.errors import SimulationError
from snowmpm.io import Run
from snowmpm.ladder.answers import answer_of
from snowmpm.ladder.questions import Ask
from snowmpm.ladder.study import spent
from snowmpm.scenes import load_scene
from snowmpm.scenes.library import library

FILE = Path(__file__).parent / "figures" / "library_answers.csv"
COLUMNS = ("scene", "answer", "grid", "dx", "value", "seconds", "why")


@dataclass(frozen=True)
class Told:
    """answer: in words, as in the header of the scene; of: (scene, `Run`) -> number; finer: spacing of the fine grid
    over that of the scene, None where a finer one would be another scene, `also` other keys of it; law: the same of
    experiments, of the `Run`."""

    answer: str
    of: Callable
    finer: float | None = 0.5
    also: Mapping = field(default_factory=dict)
    law: Callable | None = None


def asked(question, answer, finer=0.5, **also):
    """Of a question of the ladder."""
    return Told(answer, lambda scene, run: answer_of(run, Ask.of(scene, question)), finer, also)


def largest(column, answer, finer=0.5):
    """Of the largest size of a column of the history."""
    return Told(answer, lambda scene, run: float(np.nanmax(np.abs(run.history[column]))), finer)


def moved(column, answer, finer=0.5):
    """Of the change of a column of the history from start to end."""
    return Told(answer, lambda scene, run: float(run.history[column][-1] - run.history[column][0]), finer)


def measured(name, answer, finer=0.5):
    """Of a quantity that `snowmpm compare` measures."""
    def quantity(run):
        return next(one for one in reference_of(Case("", run)).quantities() if one.name == name)

    return Told(answer, lambda scene, run: quantity(run).measured, finer,
                law=None if finer else lambda run: quantity(run).low)


def press(scene, run):
    """Mean force of the piston over its way [N]."""
    history = run.history
    return float(np.trapezoid(np.abs(history["piston_force_z"]), history["time"]) / np.ptp(history["time"]))


def middle(scene, run):
    """Way of the centre of mass [m]."""
    first, last = run.frame(0, []).points, run.frame(-1, []).points
    return float(np.linalg.norm(last.mean(axis=0) - first.mean(axis=0)))


RELEASE, RUN_OUT, LOAD, CUT = "whether the slab releases", "run-out", "peak load", "critical cut length"
TOLD = {
    "avalanche_depth_averaged": asked("run-out", RUN_OUT),
    "avalanche_on_raster": asked("run-out", RUN_OUT),
    "block_wall_2d": moved("block_6_x", "way of the uppermost block"),
    "boulders_2d": moved("boulder_x", "way of the boulder"),
    "column_collapse_2d": measured("run-out", RUN_OUT),
    "column_collapse_3d": measured("run-out", RUN_OUT, None),
    "crown_and_flanks": asked("release", RELEASE, None),
    "elastic_beam": measured("depth of the first swing", "depth of the first swing"),
    "fence_2d": largest("fence_foot_moment", "largest moment at the foot"),
    "flexible_wall_2d": largest("wall_top_x", "largest displacement of the top"),
    "flow_cold_dense": Told("way of its middle", middle),
    "flow_sliding_slab": asked("run-out", RUN_OUT),
    "flow_warm_plug": asked("run-out", RUN_OUT),
    "flow_warm_shear": asked("run-out", RUN_OUT),
    "flume_impact": asked("load", LOAD),
    "impact_mast": asked("load", LOAD, 0.625),
    "impact_wall_2d": asked("load", LOAD),
    "impact_wedge_2d": asked("load", LOAD),
    "mast": largest("steel_top_x", "largest displacement of the tube", None),
    "microstructure": Told("mean force of the piston", press, None),
    "microstructure_2d": Told("mean force of the piston", press, None),
    "natural_release": asked("release", RELEASE, None),
    "oedometer": measured("axial stress", "axial stress"),
    "pst": asked("critical-length", CUT, None),
    "pst_2d": asked("critical-length", CUT, **{"saw_test.weak_layer.cells": 4}),
    "remote_trigger_2d": asked("release", RELEASE, None),
    "sand_between_plates": measured("run-out", "half-width at rest"),
    "skier_trigger": asked("release", RELEASE, None),
    "slab_release": asked("run-out", RUN_OUT, None),
    "slab_release_2d": asked("release", RELEASE, None),
    "slab_release_resolved": asked("run-out", RUN_OUT, None),
    "slope_failure": moved("front_distance", "way of the toe"),
    "slush_dam_2d": moved("front", "way of the front"),
    "slushflow": asked("run-out", RUN_OUT),
    "whumpf_2d": asked("settlement", "how far the snow sinks", None),
}
"""Finer cells are None for weak layers of particles, whose softening is chosen for the cells of the scene, and where
they would take longer than three minutes."""


def rows_of(name, grids=("wider", "own", "finer")):
    """Rows of a scene, from wide cells to fine ones."""
    told, own = TOLD[name], load_scene(name)
    for grid, times in (("wider", 2.0), ("own", 1.0), ("finer", told.finer)):
        if times is None or grid not in grids:
            continue
        scene = load_scene(name, {} if times == 1.0 else {
            "solver.dx": float(f"{times * own.solver.dx:.4g}"), **(told.also if grid == "finer" else {})})
        value = seconds = why = law = ""
        with tempfile.TemporaryDirectory() as folder:
            path = write_text(Path(folder) / "scene.toml", scene.to_toml())
            try:
                seconds = spent(["run", path, "-o", Path(folder) / "run", "--accept-cost", "--quiet"])
                run = Run(Path(folder) / "run")
                value = told.of(scene, run)
                law = told.law(run) if told.law and grid == "own" else ""
            except SimulationError as error:
                why = str(error).removeprefix("error: ").replace(f"{path}: ", "")
        yield dict(zip(COLUMNS, (name, told.answer, grid, f"{scene.solver.dx:.4g}",
                                 value if value == "" else f"{value:.5g}", seconds and f"{seconds:.1f}", why),
                       strict=True))
        if law != "":
            yield dict(zip(COLUMNS, (name, told.answer, "law", "0", f"{law:.5g}", "", ""), strict=True))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", nargs="*", default=[])
    parser.add_argument("--grids", nargs="+", default=["wider", "own", "finer"])
    chosen = parser.parse_args()
    kept = []
    if FILE.exists():
        with FILE.open(encoding="utf-8", newline="") as file:
            kept = list(csv.DictReader(file))
    assert TOLD.keys() == set(library())
    for name in chosen.only or TOLD:
        for row in rows_of(name, chosen.grids):
            print(", ".join(row.values()), flush=True)
            kept = [old for old in kept if (old["scene"], old["grid"]) != (name, row["grid"])] + [row]
        kept.sort(key=lambda row: (row["scene"], -float(row["dx"])))
        with FILE.open("w", encoding="utf-8", newline="") as file:
            writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
            writer.writeheader()
            writer.writerows(kept)


if __name__ == "__main__":
    main()
