"""How still a run of MPM begins, and what that takes: damped steps beside the solved balance, on library scenes.

    python tests/benchmarks/settling.py [SCENE ...] [-o FILE]

For each scene both ways in turn, in one process and on one thread: processor time until the clock starts, and the
largest speed in the 300 free steps after it over sqrt(g D), D the depth of the snow. Writes settling.csv.
"""

import argparse
import csv
import time
from pathlib import Path

import numpy as np

from snowmpm.compiler import runtime
from snowmpm.running.simulation import Simulation
from snowmpm.scenes import load_scene

SCENES = ("pst_2d", "whumpf_2d", "remote_trigger_2d", "skier_trigger")
LATER = {"pst_2d": {"saw_test.saw_start": 1.0}}
"""Of scenes whose trigger comes within the free steps."""
STEPS = 300
COLUMNS = ("scene", "particles", "damped", "static", "damped_s", "static_s")


def settled(name, relaxation):
    """(Simulation at the start of its clock, processor seconds that settling took)."""
    scene = load_scene(name, {"initial.relaxation": relaxation, **LATER.get(name, {})})
    waiting = Simulation(scene.model_copy(update={"initial": scene.initial.model_copy(update={"stress": "geostatic"})}))
    waiting.solver.step(waiting.solver.stable_dt()[0])  # kernels of a step are compiled
    begun = time.process_time()
    one = Simulation(scene)
    return one, time.process_time() - begun


def still(one):
    """Largest speed in the first steps, over sqrt(g D)."""
    speeds = []
    for _ in range(STEPS):
        one.step()
        speeds.append(one.max_speed)
    return max(speeds) / np.sqrt(9.81 * one.model.depth)


def main():
    words = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    words.add_argument("scenes", nargs="*", default=SCENES)
    words.add_argument("-o", "--output", type=Path, default=Path(__file__).parent / "figures" / "settling.csv")
    asked = words.parse_args()
    runtime.start("cpu", 1)
    rows = []
    for name in asked.scenes:
        row = {"scene": name}
        for relaxation in ("damped", "static"):
            one, spent = settled(name, relaxation)
            row |= {"particles": one.solver.particles.count, relaxation: f"{still(one):.2g}",
                    f"{relaxation}_s": f"{spent:.1f}"}
        rows.append(row)
        print(*row.values(), flush=True)
    with asked.output.open("w", newline="", encoding="utf-8") as file:
        table = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        table.writeheader()
        table.writerows(rows)


if __name__ == "__main__":
    main()
