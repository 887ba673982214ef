"""Permeability of samples of snow against the fit of Calonne et al. (2012), and the scatter of its own samples (U4).

    python tests/benchmarks/permeability_calonne.py [SEED ...]

The shipped sample, and samples of the generator that made it (`setup.random_microstructure`) of other densities. These
are periodic, with one length scale; they were not chosen by their permeability. Writes figures/permeability_calonne.csv
and docs/figures/permeability_calonne.png.
"""

import sys
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from snowmpm.compiler import runtime
from snowmpm.draft import write_table
from snowmpm.micro.permeability import CALONNE_SCATTER, calonne
from snowmpm.micro.sample import Sample
from snowmpm.micro.study import examine
from snowmpm.scenes.library import FOLDER
from snowmpm.setup.random_microstructure import random_microstructure

HERE = Path(__file__).parent
VOXEL, SIDE, CORRELATION = 5e-5, 48, 3.0
FRACTIONS = (0.17, 0.22, 0.28, 0.34, 0.41, 0.48)
NAMES = ["sample", "density", "equivalent_radius", "grains", "k_x", "k_y", "k_z", "k_over_fit"]
ALONG = {"x": "<", "y": "v", "z": "^"}


def main(seeds):
    runtime.start("cpu", threads=1)
    samples = [Sample.read(FOLDER / "snow_3d.npz", VOXEL)]
    samples += [Sample(random_microstructure((SIDE,) * 3, fraction, CORRELATION, seed) == 1, VOXEL,
                       f"made {fraction:g}, seed {seed}") for seed in seeds for fraction in FRACTIONS]
    rows = []
    for sample in samples:
        record, _ = examine(sample)
        rows.append([sample.name, record["density"], record["equivalent_radius"], record["grains"],
                     *np.diag(record["permeability"]), record["permeability_over_calonne"]])
        print(rows[-1], flush=True)
    write_table(HERE / "figures" / "permeability_calonne.csv", NAMES,
                ([row[0], *(f"{value:.5g}" for value in row[1:])] for row in rows))
    draw(rows)


def draw(rows):
    """k / r^2 against the density: the fit is a line."""
    figure = Figure(figsize=(6.4, 4.2), layout="constrained")
    panel = figure.subplots()
    rho = np.linspace(100.0, 500.0, 50)
    fit = calonne(1.0, rho)
    panel.semilogy(rho, fit, "k-", lw=1.2, label="fit to 35 samples of snow, Calonne et al. (2012)")
    panel.fill_between(rho, fit / CALONNE_SCATTER, fit * CALONNE_SCATTER, color="0.88",
                       label=f"their scatter, a factor of {CALONNE_SCATTER:g}")
    numbers = np.array([row[1:] for row in rows], float)
    for which, colour, label in ((slice(0, 1), "C3", "shipped sample"), (slice(1, None), "C0", "made samples")):
        of = numbers[which]
        for k, marker in enumerate(ALONG.values()):
            panel.plot(of[:, 0], of[:, 3 + k] / of[:, 1] ** 2, marker, color=colour, ms=4, alpha=0.5)
        panel.plot(of[:, 0], of[:, 3:6].mean(axis=1) / of[:, 1] ** 2, "o", color=colour, ms=7, label=f"{label}, mean")
    panel.plot([], [], "^", color="0.5", ms=4, label="along x (left), y (down), z (up)")
    panel.set(xlabel="density [kg/m³]", ylabel="permeability / (equivalent radius)²")
    panel.legend(fontsize=8)
    figure.savefig(HERE.parents[1] / "docs" / "figures" / "permeability_calonne.png", dpi=100)


if __name__ == "__main__":
    main([int(text) for text in sys.argv[1:]] or [1, 2])
