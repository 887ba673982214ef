"""What depth-averaging changes: the library's valley by MPM in three dimensions and depth-averaged.

    python tests/benchmarks/depth_against_mpm.py [RUNS]

Runs `avalanche_on_raster` on cells of 1.5 m, and with solver.method = "depth" on cells of 5 m, with the same Coulomb
friction of the ground and map cells of 10 m, and writes snowmpm/measured/depth_averaged.csv, which `snowmpm check`
quotes. Runs that are complete in the folder RUNS (mpm, depth) are read, not made again. Ten minutes on one core.
"""

import csv
import sys
import tempfile
from pathlib import Path

import snowmpm
from snowmpm.io import Run
from snowmpm.measured.depth_averaged import SAID, TABLE

SETTINGS = {"mpm": {"output.map_cell": 10.0, "solver.dx": 1.5},
            "depth": {"output.map_cell": 10.0, "solver.method": "depth", "solver.dx": 5.0}}


def numbers(folder, settings):
    there = (folder / "summary.json").exists() and Run(folder).complete
    run = Run(folder) if there else snowmpm.run(snowmpm.load_scene("avalanche_on_raster", settings), folder)
    found = {name: run.hazard["numbers"][name] for name in SAID}
    return {**found, "particle_steps": run.summary["particle_steps"]}


def main():
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else tempfile.mkdtemp())
    found = {name: numbers(folder / name, settings) for name, settings in SETTINGS.items()}
    with open(TABLE, "w", newline="", encoding="utf-8") as file:
        rows = csv.writer(file, lineterminator="\n")
        rows.writerow(["quantity", *found])
        rows.writerows([name, *(f"{one[name]:.5g}" for one in found.values())] for name in found["mpm"])


if __name__ == "__main__":
    main()
