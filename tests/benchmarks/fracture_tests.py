"""Pictures of the fracture tests: a notched beam on three grids (F2), half discs (F3) and rings (F4) with their cracks.

    python tests/benchmarks/fracture_tests.py [-o FOLDER]
"""

import argparse
import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

sys.path.insert(0, str(Path(__file__).parents[2]))
from snowmpm.compiler import runtime
from tests.support import beam_of_elements
from tests.support import cracked_specimens as specimens

GRIDS = (0.004, 0.003, 0.002)
ANGLES = (0, 15, 30, 45, 60)
RATIOS = (0.2, 0.3, 0.4)
MM = 1e3


def pattern(axes, tested, title):
    """Damage of the particles when the specimen has broken, where they were at the start."""
    points = axes.scatter(*(MM * tested.x.T), c=tested.damage[specimens.broken(tested)], s=1.5, lw=0.0,
                          cmap="magma_r", vmin=-0.15, vmax=1.0)
    axes.set(aspect="equal")
    axes.set_axis_off()
    axes.set_title(title, fontsize=9)
    return points


def draw_beams(beams):
    """Force over deflection on three grids and by finite elements, and the crack."""
    figure, axes = plt.subplots(1, 2, figsize=(11, 3.8), width_ratios=(1.2, 1.0), layout="constrained")
    deflection, force = beam_of_elements.curve()
    axes[0].plot(MM * deflection, force, color="0.3", label="finite elements")
    for beam, style in zip(beams, (":", "--", "-"), strict=True):
        axes[0].plot(MM * specimens.deflection(beam), beam.force, style, color="C0", label=f"dx = {MM * beam.dx:g} mm")
        spent = beam.work / specimens.bonds_lost(beam)
        print(f"dx {MM * beam.dx:g} mm: peak {beam.force.max():.2f} N/m, work {spent:.3f} of the bonds", flush=True)
    axes[0].set(xlabel="deflection [mm]", ylabel="load per width [N/m]", xlim=(0.0, None), ylim=(0.0, None))
    axes[0].legend(frameon=False)
    pattern(axes[1], beams[-1], "damage, dx = 2 mm")
    return figure


def draw_rocks(half_discs, rings):
    """Cracks of half discs and rings, peak loads over the angle, load over the way of the platen."""
    figure, axes = plt.subplots(2, 6, figsize=(13, 5), layout="constrained", width_ratios=[1.0] * 5 + [1.5])
    for ax, (angle, tested) in zip(axes[0], half_discs.items(), strict=False):
        points = pattern(ax, tested, f"notch at {angle}°")
    for ax, (ratio, tested) in zip(axes[1], rings.items(), strict=False):
        pattern(ax, tested, f"d/D = {ratio:g}")
    axes[0, 5].plot(list(half_discs), [tested.force.max() for tested in half_discs.values()], "o-")
    axes[0, 5].set(xlabel="angle of the notch [°]", ylabel="peak load [N/m]", ylim=(0.0, None))
    for ratio, tested in rings.items():
        axes[1, 5].plot(MM * tested.way, tested.force, label=f"d/D = {ratio:g}")
    axes[1, 5].set(xlabel="way of the platen [mm]", ylabel="load [N/m]", xlim=(0.0, None), ylim=(0.0, None))
    axes[1, 5].legend(frameon=False, fontsize=8)
    for ax in axes[1, 3:5]:
        ax.set_axis_off()
    figure.colorbar(points, ax=axes[1, 3], label="damage", location="left", boundaries=np.linspace(0.0, 1.0, 101),
                    ticks=(0.0, 0.5, 1.0), fraction=0.5)
    return figure


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("-o", "--out", type=Path, default=Path("docs/figures"))
    out = parser.parse_args().out
    runtime.start("cpu", threads=1)
    draw_beams([specimens.bent(dx) for dx in GRIDS]).savefig(out / "notched_beam.png", dpi=100)
    half_discs = {angle: specimens.half_disc(float(angle)) for angle in ANGLES}
    rings = {ratio: specimens.ring(ratio) for ratio in RATIOS}
    draw_rocks(half_discs, rings).savefig(out / "rock_cracks.png", dpi=100)


if __name__ == "__main__":
    main()
