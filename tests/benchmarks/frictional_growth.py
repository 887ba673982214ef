"""How fast disturbances of a frictional sheet grow, by law and grid (R4).

    python tests/benchmarks/frictional_growth.py [--cells 20 28 40 56 80] [-o FOLDER]

The slab of M15 on rough ground of 35 degrees, sin(phi) = mu_s = 0.5, 0.4 m deep, stirred by 1e-6 m/s
(`snowmpm.study.problems.frictional_growth`). Two minutes on one core. Writes frictional_growth.csv and .png.
"""

import argparse
import csv
from pathlib import Path

import matplotlib
import numpy as np

import snowmpm
from snowmpm.materials import CriticalStateHypoplastic, MohrCoulomb, SolidToGas
from snowmpm.study.atlas.granular import mu_of_i
from snowmpm.study.problems.frictional_growth import growth_rate
from snowmpm.study.problems.granular_slab import granular

matplotlib.use("Agg")
from matplotlib import pyplot as plt

HERE = Path(__file__).parent
SOIL = {"density": 1500.0, "youngs_modulus": 1e6, "poisson_ratio": 0.3}
FRICTIONAL = granular(np.arcsin(0.5))
SAND = {"density": 1500.0, "youngs_modulus": 1e6, "reference_pressure": 5e3, "poisson_ratio": 0.0,
        "friction_angle": 30.0, "least_void_ratio": 0.5, "critical_void_ratio_limit": 0.55,
        "critical_void_ratio_drop": 0.25, "density_effect": 0.2, "void_ratio": 0.79}
"""Near its critical state, 0.8 without pressure."""

LAWS = {
    "Drucker-Prager": FRICTIONAL,
    "Mohr-Coulomb": MohrCoulomb(**SOIL, friction_angle=30.0),
    "Drucker-Prager, dilation 10 degrees": FRICTIONAL.model_copy(update={"dilation_angle": 10.0}),
    "Drucker-Prager, dilation 30 degrees": FRICTIONAL.model_copy(update={"dilation_angle": 30.0}),
    "mu(I), grains of 2 mm": mu_of_i(0.002),
    "mu(I), 10 mm": mu_of_i(0.01),
    "mu(I), 30 mm": mu_of_i(0.03),
    "hypoplastic, critical state": CriticalStateHypoplastic(**SAND),
    "two stresses, solid to gas": SolidToGas(**SAND, collision_time=8e-4),
}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--cells", type=int, nargs="+", default=[20, 28, 40, 56, 80])
    parser.add_argument("-o", "--output", type=Path, default=HERE / "figures")
    options = parser.parse_args()
    snowmpm.start("cpu", threads=1)
    figure, axis = plt.subplots(figsize=(7, 4.5), constrained_layout=True)
    rows = []
    for name, law in LAWS.items():
        found = [growth_rate(law, cells) for cells in options.cells]
        rows += [{"law": name, "cells": cells, "growth_per_s": round(rate, 1)}
                 for cells, rate in zip(options.cells, found, strict=True)]
        axis.plot(options.cells, np.maximum(found, 0.0), "o-", label=name)
        print(name, *(f"{rate:.0f}" for rate in found), flush=True)
    axis.set(xlabel="cells over the depth of the sheet", ylabel="growth of disturbances [1/s]", xscale="log",
             xticks=options.cells, xticklabels=options.cells)
    axis.minorticks_off()
    axis.grid(alpha=0.3)
    axis.legend(fontsize=8)
    figure.savefig(options.output / "frictional_growth.png", dpi=80)
    with open(options.output / "frictional_growth.csv", "w", newline="", encoding="utf-8") as file:
        table = csv.DictWriter(file, list(rows[0]))
        table.writeheader()
        table.writerows(rows)


if __name__ == "__main__":
    main()
