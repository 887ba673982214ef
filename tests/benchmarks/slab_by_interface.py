"""The library's slab avalanche with its weak layer resolved, and as an interface on coarser cells, side by side.

    python tests/benchmarks/slab_by_interface.py RESOLVED INTERFACE [-o FOLDER]

RESOLVED, INTERFACE: runs of `slab_release_resolved` and `docs/slab_release_interface.toml`. Prints what the slab does
in both: when it is released, where its upper edge, its sides and its front are, and its energies a kilogram; writes
slab_by_interface.png.
"""

import argparse
from pathlib import Path

import matplotlib
import numpy as np

from snowmpm import load_scene
from snowmpm.io import Run

matplotlib.use("Agg")
from matplotlib import pyplot as plt

ROOT = Path(__file__).resolve().parents[2]
TIMES = (1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0)
DRAWN = (2.0, 4.0, 8.0)
RELEASED = 0.5
"""Mean speed of the slab [m/s]."""
EDGE = 0.005
"""Share of the slab beyond an edge of it."""
GRAVITY = 9.81


class Slab:
    """The slab of a run: positions (n, 3) [m] and speed (n,) [m/s] by frame."""

    def __init__(self, path, scene):
        self.run, self._material = Run(path), list(load_scene(scene).materials).index("slab")
        self.times = np.asarray(self.run.times)
        self.height = self.frame(0)[0][:, 2].mean()

    def frame(self, i):
        frame = self.run.frame(i)
        own = np.asarray(frame.fields["material"]).ravel() == self._material
        return frame.positions[own], np.linalg.norm(np.asarray(frame.fields["velocity"])[own], axis=1)

    def at(self, time):
        return self.frame(int(np.abs(self.times - time).argmin()))

    def release(self):
        """Time at which the slab has got its mean speed [s]."""
        before = 0.0
        for i, time in enumerate(self.times):
            speed = self.frame(i)[1].mean()
            if speed >= RELEASED:
                return time - (speed - RELEASED) / (speed - before) * (time - self.times[i - 1])
            before = speed
        return np.nan

    def told(self, time):
        """Numbers of a moment by name."""
        x, speed = self.at(time)
        upper, lower = np.quantile(x[:, 0], (EDGE, 1.0 - EDGE))
        right, left = np.quantile(x[:, 1], (EDGE, 1.0 - EDGE))
        return {"upper edge x [m]": upper, "flanks y [m]": (right, left), "front x [m]": lower,
                "mean speed [m/s]": speed.mean(), "kinetic energy [J/kg]": 0.5 * (speed**2).mean(),
                "fall [J/kg]": GRAVITY * (self.height - x[:, 2].mean())}


def shown(value):
    return " to ".join(f"{one:.2f}" for one in np.atleast_1d(value))


def draw(slabs, path):
    figure, axes = plt.subplots(len(slabs), len(DRAWN), figsize=(10, 4.6), sharex=True, sharey=True,
                                constrained_layout=True)
    for row, (name, slab) in zip(axes, slabs.items(), strict=True):
        for axis, time in zip(row, DRAWN, strict=True):
            x, speed = slab.at(time)
            some = slice(None, None, max(1, len(x) // 12_000))
            dots = axis.scatter(*x[some, :2].T, c=speed[some], s=1.0, cmap="viridis", vmin=0.0, vmax=10.0,
                                rasterized=True)
            axis.set(aspect="equal", xlim=(0.0, 55.0), ylim=(0.0, 26.0), title=f"{name}, {time:g} s")
        row[0].set_ylabel("y [m]")
    for axis in axes[-1]:
        axis.set_xlabel("x [m]")
    figure.colorbar(dots, ax=axes, label="speed of the slab [m/s]", shrink=0.8)
    figure.savefig(path, dpi=90)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("resolved", type=Path)
    parser.add_argument("interface", type=Path)
    parser.add_argument("-o", "--output", type=Path, default=ROOT / "docs" / "figures")
    options = parser.parse_args()
    slabs = {"resolved": Slab(options.resolved, "slab_release_resolved"),
             "interface": Slab(options.interface, str(ROOT / "docs" / "slab_release_interface.toml"))}
    for name, slab in slabs.items():
        facts = slab.run.summary
        print(f"{name}: released at {slab.release():.2f} s; {facts['particles']} particles, {facts['steps']} steps,"
              f" {facts['particle_steps']:.3g} particle steps, {facts['processor_time']:.0f} s of processor time")
    for time in TIMES:
        told = [slab.told(time) for slab in slabs.values()]
        for name, value in told[0].items():
            print(f"t = {time:g} s, {name}: {shown(value)} and {shown(told[1][name])}")
    draw(slabs, options.output / "slab_by_interface.png")


if __name__ == "__main__":
    main()
