"""Permeability of simple cubic spheres: error against voxels a cell and seconds (U2).

    python tests/benchmarks/permeability_voxels.py [VOXELS ...]

Against Zick and Homsy (1982). Writes figures/permeability_voxels.csv and docs/figures/permeability_voxels.png. Seconds
are of the processor, one thread, without compilation; those of a busy machine are too many by a third or so.
"""

import sys
import time
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from snowmpm.compiler import runtime
from snowmpm.draft import write_table
from snowmpm.micro.permeability import permeability
from tests.support.spheres import ZICK_HOMSY, simple_cubic

HERE = Path(__file__).parent
FRACTIONS = (0.125, 0.343, 0.5236)
NAMES = ["solid_fraction", "voxels", "k_over_radius2", "error", "steps", "seconds"]


def main(sizes):
    runtime.start("cpu", threads=1)
    permeability(~simple_cubic(8, 0.216)[0], 1.0, (0,))  # compiles
    rows = []
    for fraction in FRACTIONS:
        for n in sizes:
            ice, radius = simple_cubic(n, fraction)
            start = time.process_time()
            found = permeability(~ice, 1.0, (0,))
            seconds = time.process_time() - start
            value = found.mean / radius**2
            rows.append([fraction, n, value, value / ZICK_HOMSY[fraction] - 1.0, int(found.steps[0]), seconds])
            print(rows[-1], flush=True)
    write_table(HERE / "figures" / "permeability_voxels.csv", NAMES,
                ([f"{value:.5g}" for value in row] for row in rows))
    draw(rows)


def draw(rows):
    figure = Figure(figsize=(8.0, 3.2), layout="constrained")
    left, right = figure.subplots(1, 2, sharey=True)
    for fraction in FRACTIONS:
        of = np.array([row for row in rows if row[0] == fraction])
        for panel, column in ((left, 1), (right, 5)):
            panel.loglog(of[:, column], 100.0 * np.abs(of[:, 3]), "o-", label=f"solid fraction {fraction:g}")
    left.set(xlabel="voxels a cell", ylabel="error of the permeability [%]")
    right.set(xlabel="seconds of one core")
    left.legend(fontsize=8)
    figure.savefig(HERE.parents[1] / "docs" / "figures" / "permeability_voxels.png", dpi=100)


if __name__ == "__main__":
    main([int(text) for text in sys.argv[1:]] or [12, 16, 24, 32, 48, 64])
