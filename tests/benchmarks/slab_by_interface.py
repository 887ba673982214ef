"""A slab avalanche with its weak layer resolved, and with an interface in its place, side by side.

    python tests/benchmarks/slab_by_interface.py RESOLVED INTERFACE [-o FILE]

RESOLVED, INTERFACE: folders of runs of `slab_release_resolved` and of `slab_release` or
`docs/slab_release_interface.toml`. Prints what the slab does in both: when it is released, where its upper edge, its
sides and its front are, its energies a kilogram, what it cost; draws the slab, its front over time and where it lies
at the end to FILE, slab_by_interface.png by default.
"""

import argparse
from pathlib import Path

import matplotlib
import numpy as np

from snowmpm.io import Run

matplotlib.use("Agg")
from matplotlib import pyplot as plt

TIMES = (1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0)
DRAWN = (2.0, 4.0, 8.0)
RELEASED = 0.5
"""Mean speed of the slab [m/s]."""
EDGE = 0.005
"""Share of the slab beyond an edge of it."""
GRAVITY = 9.81


class Slab:
    """The slab of a run: positions (n, 3) [m] and speed (n,) [m/s] by frame."""

    def __init__(self, folder):
        self.run = Run(folder)
        self._material = list(self.run.provenance["materials"]).index("slab")
        self.times = np.asarray(self.run.times)
        self.height = self.frame(0)[0][:, 2].mean()

    def frame(self, i):
        frame = self.run.frame(i)
        own = np.asarray(frame.fields["material"]).ravel() == self._material
        return frame.positions[own], np.linalg.norm(np.asarray(frame.fields["velocity"])[own], axis=1)

    def at(self, time):
        return self.frame(int(np.abs(self.times - min(time, self.times[-1])).argmin()))

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
    figure = plt.figure(figsize=(10, 6.2), constrained_layout=True)
    plans, curves = figure.subfigures(2, 1, height_ratios=(3, 2))
    axes = plans.subplots(len(slabs), len(DRAWN), sharex=True, sharey=True)
    for row, (name, slab) in zip(axes, slabs.items(), strict=True):
        for axis, time in zip(row, DRAWN, strict=True):
            x, speed = slab.at(time)
            some = slice(None, None, max(1, len(x) // 12_000))
            dots = axis.scatter(*x[some, :2].T, c=speed[some], s=1.0, cmap="viridis", vmin=0.0, vmax=10.0,
                                rasterized=True)
            axis.set(aspect="equal", xlim=(0.0, 60.0), ylim=(0.0, 26.0), title=f"{name}, {time:g} s")
        row[0].set_ylabel("y [m]")
    for axis in axes[-1]:
        axis.set_xlabel("x [m]")
    plans.colorbar(dots, ax=axes, label="speed of the slab [m/s]", shrink=0.8)
    front, deposit = curves.subplots(1, 2)
    for name, slab in slabs.items():
        seconds = f"{name}, {slab.run.summary['processor_time']:.0f} s of processor time"
        front.plot(slab.times, [np.quantile(slab.frame(i)[0][:, 0], 1.0 - EDGE) for i in range(len(slab.times))],
                   label=seconds)
        deposit.hist(slab.at(np.inf)[0][:, 0], bins=60, range=(0.0, 60.0), density=True, histtype="step")
    front.set(xlabel="time [s]", ylabel="front of the slab, x [m]")
    front.legend(fontsize="small")
    deposit.set(xlabel="x [m]", ylabel="share at the end [1/m]")
    figure.savefig(path, dpi=90)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("resolved", type=Path)
    parser.add_argument("interface", type=Path)
    parser.add_argument("-o", "--output", type=Path, default=Path("slab_by_interface.png"))
    options = parser.parse_args()
    slabs = {"resolved": Slab(options.resolved), "interface": Slab(options.interface)}
    for name, slab in slabs.items():
        facts = slab.run.summary
        print(f"{name}: released at {slab.release():.2f} s; {facts['particles']} particles, {facts['steps']} steps,"
              f" {facts['particle_steps']:.3g} particle steps, {facts['processor_time']:.0f} s of processor time")
    for time in (*TIMES, np.inf):
        told = [slab.told(time) for slab in slabs.values()]
        when = "at the end" if np.isinf(time) else f"t = {time:g} s"
        for name, value in told[0].items():
            print(f"{when}, {name}: {shown(value)} and {shown(told[1][name])}")
    draw(slabs, options.output)


if __name__ == "__main__":
    main()
