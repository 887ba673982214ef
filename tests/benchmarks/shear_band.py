"""A specimen that fails in a band, a quarter of it between planes of symmetry, and their loads, drawn.

    python tests/benchmarks/shear_band.py [-o FOLDER]

A minute and a half on one core. Writes shear_band.png.
"""

import argparse
import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
from matplotlib import pyplot as plt

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

import snowmpm  # noqa: E402
from tests.support.shear_band import HEIGHT, WIDTH, Specimen  # noqa: E402

SPEED = 0.02
"""At which the plates approach each other [m/s]."""


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("-o", "--output", type=Path, default=ROOT / "docs" / "figures")
    options = parser.parse_args()
    snowmpm.start("cpu", threads=1)
    found = {"whole specimen": Specimen("shear_band", WIDTH), "quarter": Specimen("shear_band_quarter", 0.5 * WIDTH)}
    most = found["whole specimen"].shear.max()
    figure, (loads, *axes) = plt.subplots(1, 3, figsize=(9, 4.2), constrained_layout=True,
                                          width_ratios=[1.5, 1.0, 1.0])
    for axis, (name, one) in zip(axes, found.items(), strict=True):
        loads.plot(100.0 * SPEED * one.time / HEIGHT, 1e-3 * one.deviator, label=name)
        mirrors = [(1, 1)] if name != "quarter" else [(1, 1), (-1, 1), (1, -1), (-1, -1)]
        for across, along in mirrors:
            shown = axis.scatter(across * one.x[:, 0], along * one.x[:, 1], c=one.shear, s=2.0, vmin=0.0, vmax=most,
                                 cmap="magma_r")
        axis.set(aspect="equal", title=name if len(mirrors) == 1 else "quarter, mirrored", xticks=[], yticks=[])
    figure.colorbar(shown, ax=axes, label="plastic shear")
    loads.set(xlabel="approach of the plates over the height [%]", ylabel="load over the section [kPa]")
    loads.grid(alpha=0.3)
    loads.legend()
    figure.savefig(options.output / "shear_band.png", dpi=75)


if __name__ == "__main__":
    main()
