"""What output costs a run: with the thread that writes, and with a solver that writes by itself.

    python writer_thread.py [FOLDER]

Runs a block of snow (2-D, 40 000 particles) for the same steps without frames, with one every fifty steps, and with
one whose disk needs as long as the solver or twice that; each with the thread, and in the solver's own. Writes
figures/writer_thread.csv: seconds of wall time a frame. The runs lie in FOLDER (by default where temporary files lie).
"""

import csv
import sys
import tempfile
import time
from pathlib import Path

from snowmpm import io
from snowmpm.compiler import runtime
from snowmpm.io import RunWriter
from snowmpm.running import loop, recorder
from snowmpm.scenes import load_scene

STEPS, EVERY = 400, 50
SCENE = """
name = "block"
dimension = 2
end_time = 1.0
[output]
interval = 1.0
fields = ["velocity", "density", "stress"]
checkpoint_interval = 1e9
[solver]
dx = 0.01
dt = 1e-4
[materials.snow]
kind = "cohesive_cam_clay"
density = 300.0
youngs_modulus = 1e6
poisson_ratio = 0.3
critical_slope = 1.2
cohesion = 0.3
hardening = 1.0
p0 = 2e4
[[bodies]]
name = "block"
material = "snow"
shape = { kind = "box", min = [0.0, 0.1], max = [1.0, 1.1] }
velocity = [0.0, -1.0]
[domain]
min = [-0.5, 0.0]
max = [1.5, 1.5]
"""


class Inline(io.Background):
    """The solver's own thread does the jobs."""

    def do(self, job):
        began = time.perf_counter()
        job()
        self.work += time.perf_counter() - began


def measured(scene, folder, background, disk):
    """Summary of a run whose disk needs so many seconds more for each frame."""
    write = RunWriter.frame

    def slow(self, *frame):
        time.sleep(disk)
        write(self, *frame)

    RunWriter.frame, recorder.Background = slow, background
    try:
        return loop.run(scene, folder).summary
    finally:
        RunWriter.frame, recorder.Background = write, io.Background


def main(folder):
    runtime.start("cpu", threads=1)
    path = Path(folder) / "block.toml"
    path.write_text(SCENE)
    dt, rows = 1e-4, []
    end, frames = STEPS * dt, STEPS // EVERY

    def case(name, interval, background, disk=0.0):
        scene = load_scene(path, {"end_time": end, "output.interval": interval})
        found = measured(scene, Path(folder) / "run", background, disk)
        times = found["wall_time_of"]
        rows.append({"case": name, "disk [s]": f"{disk:.3f}", "steps [s]": times["steps"],
                     "output [s]": times["output"], "writing [s]": found["writing_time"],
                     "steps and output, a frame [s]": f"{(times['steps'] + times['output']) / frames:.4f}"})
        print(rows[-1], flush=True)
        return found

    case("compiling", end, io.Background)
    rows.clear()
    solver = case("no frames", end, io.Background)["wall_time_of"]["steps"] / frames
    for disk in (0.0, solver, 2.0 * solver):
        case("thread", EVERY * dt, io.Background, disk)
        case("by itself", EVERY * dt, Inline, disk)
    table = Path(__file__).parent / "figures" / "writer_thread.csv"
    with open(table, "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, list(rows[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


if __name__ == "__main__":
    if len(sys.argv) > 1:
        main(sys.argv[1])
    else:
        with tempfile.TemporaryDirectory() as folder:
            main(folder)
