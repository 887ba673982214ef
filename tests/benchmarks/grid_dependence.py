"""What softening takes on grids of several spacings: as it is, and with each of three cures; all on one chart.

    python tests/benchmarks/grid_dependence.py [-o FILE]

Sheared layer of clay that softens, as it is and with nonlocal_length; weak layer that collapses, as it is and with
reference_thickness; plate with two notches that cracks, cohesive_crack. Each over what the material says; of the
weak layer over the work at the spacing that its softening is meant for.
"""

import argparse
import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

sys.path.insert(0, str(Path(__file__).parents[2]))
from snowmpm.compiler import runtime
from snowmpm.components.nonlocal_averaging.layer import LENGTH, Layer, sheared
from snowmpm.study.atlas.softening import energy_of_a_row
from tests.support.notched_plate import broken

LAYERS = tuple(LENGTH / cells for cells in (2, 3, 4, 6, 8))
ROWS = (0.25, 0.5, 1.0)
PLATES = (0.01, 0.0075, 0.006)


def curves():
    """(name, style, spacing over that of the first, work over what the material says) of each."""
    shear = [[sheared(Layer(dx, length)).softened for dx in LAYERS] for length in (None, LENGTH)]
    cells = [dx / LENGTH for dx in LAYERS]
    yield "sheared clay as it is", "C3o--", cells, shear[0]
    yield "the same, nonlocal_length", "C0o-", cells, shear[1]
    for name, style, drawn in (("collapsing layer as it is", "C1s--", False),
                               ("the same, reference_thickness", "C2s-", True)):
        yield name, style, [0.5 * ratio for ratio in ROWS], [1.0 + energy_of_a_row(ratio, drawn) for ratio in ROWS]
    yield ("crack in a plate, cohesive_crack", "C4^-", [0.5 * dx / PLATES[0] for dx in PLATES],
           [broken(dx, "drawn").work for dx in PLATES])


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("-o", "--out", type=Path, default=Path("docs/figures/grid_dependence.png"))
    out = parser.parse_args().out
    runtime.start("cpu", threads=1)
    figure, axes = plt.subplots(figsize=(7.5, 4.4), layout="constrained")
    for name, style, spacing, work in curves():
        axes.plot(spacing, work, style, label=name)
        print(name, [f"{x:.3g}: {y:.3f}" for x, y in zip(spacing, work, strict=True)], flush=True)
    axes.axhline(1.0, color="0.3", lw=0.8)
    axes.set(xlabel="cell over the length of the cure (crack: over twice the coarsest cell) [-]", xlim=(0.0, 0.53),
             ylabel="work of softening over what the material says [-]", ylim=(0.0, 1.6))
    axes.legend(frameon=False, fontsize=8, loc="lower right")
    figure.savefig(out, dpi=120)


if __name__ == "__main__":
    main()
