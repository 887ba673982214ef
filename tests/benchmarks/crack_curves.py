"""Curves and energies of a notched plate that cracks, on three grids, with and without what makes them one.

    python tests/benchmarks/crack_curves.py [-o FILE]
"""

import argparse
import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

sys.path.insert(0, str(Path(__file__).parents[2]))
from snowmpm.compiler import runtime
from tests.support.notched_plate import LENGTH, PLATE, WIDTH, broken

GRIDS = (0.01, 0.0075, 0.006)
CASES = {
    "cell's length, f_bar = whole": ({}, "C0"),
    "cell's length alone": ({"f_bar": False}, "C1"),
    "softening strain of the card (10 mm), f_bar = whole": ({"length": 0.01}, "C2"),
}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("-o", "--out", type=Path, default=Path("docs/figures/cohesive_cracks.png"))
    out = parser.parse_args().out
    runtime.start("cpu", threads=1)
    figure, (curves, energies, pattern) = plt.subplots(1, 3, figsize=(12, 3.8), layout="constrained")
    styles = dict(zip(GRIDS, ("-", "--", ":"), strict=True))
    for name, (options, color) in CASES.items():
        plates = [broken(dx, "drawn", **options) for dx in GRIDS]
        for plate in plates:
            curves.plot(1e3 * plate.opened, plate.force, styles[plate.dx], color=color)
        energies.plot([1e3 * dx for dx in GRIDS], [plate.work for plate in plates], "o-", color=color, label=name)
        print(name, [round(plate.work, 3) for plate in plates], flush=True)
    for dx, style in styles.items():
        curves.plot([], [], style, color="0.3", label=f"dx = {1e3 * dx:g} mm")
    curves.set(xlabel="opening of the grips [mm]", ylabel="force per width [N/m]", xlim=(0.0, None), ylim=(0.0, None))
    curves.legend(frameon=False)
    energies.axhline(1.0, color="0.3", lw=0.8)
    energies.set(xlabel="dx [mm]", ylabel="work over G_f times the area [-]", ylim=(0.0, 2.0))
    energies.legend(frameon=False, fontsize=8, loc="lower right")
    plate = broken(GRIDS[1], "bent")
    shown = abs(plate.x[:, 0]) < LENGTH / 2
    points = pattern.scatter(*(1e3 * plate.x[shown].T), c=plate.damage[shown], s=6, cmap="viridis", vmin=0, vmax=1)
    pattern.set(xlabel="x [mm]", ylabel="y [mm]", aspect="equal", ylim=(0.0, 1e3 * WIDTH))
    figure.colorbar(points, label="damage, bent plate", shrink=0.7)
    figure.suptitle(f"Plate with two notches, f_t = {PLATE.strength / 1e3:g} kPa, G_f = {PLATE.fracture_energy:g} J/m²")
    figure.savefig(out, dpi=110)


if __name__ == "__main__":
    main()
