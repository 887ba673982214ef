"""A slope of sensitive clay that fails backwards, on three grids, drawn at the times of the source's figure.

    python tests/benchmarks/sensitive_clay.py [-o FILE]

Two minutes on one core. F6 of docs/verification.md.
"""

import argparse
import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))
from snowmpm.compiler import runtime  # noqa: E402
from tests.support.sensitive_clay import GRIDS, RUN_OUT, TIMES, TOE, slope  # noqa: E402


def draw(path):
    """Rows of times, columns of grids; colour: plastic strain."""
    figure, axes = plt.subplots(len(TIMES), len(GRIDS), figsize=(13, 3.1), layout="constrained", sharex=True,
                                sharey=True)
    for column, dx in zip(axes.T, GRIDS, strict=True):
        for axis, one in zip(column, slope(dx), strict=True):
            shown = axis.scatter(*one.x.T, c=one.strain, s=(3.4 * dx) ** 2, lw=0.0, vmin=0.0, vmax=1.0, cmap="magma_r")
            axis.axvline(TOE + RUN_OUT, color="0.5", lw=0.8, ls=":")  # published
            axis.set(aspect="equal", xlim=(0.0, 49.0), ylim=(0.0, 5.6))
            axis.set_title(f"cells of {100 * dx:.0f} cm, {one.time:g} s: {one.run_out:.1f} m", fontsize=9)
            print(f"{dx:.3f} m, {one.time:g} s: tip {one.run_out:.2f} m, 99 % within {one.of_most:.2f} m, scarp at"
                  f" {one.scarp:.2f} m, {100 * (one.strain > 0.4).mean():.0f} % remoulded, at most {one.speed:.2f} m/s",
                  flush=True)
    figure.colorbar(shown, ax=axes, label="plastic strain", extend="max")
    figure.savefig(path, dpi=110)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("-o", "--out", type=Path, default=ROOT / "docs" / "figures" / "sensitive_clay.png")
    out = parser.parse_args().out
    runtime.start("cpu", threads=1)
    draw(out)


if __name__ == "__main__":
    main()
