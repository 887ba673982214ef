"""Plan of a remote trigger: when the weak layer breaks where, and what slides in the end.

    python tests/benchmarks/remote_trigger.py [--run FOLDER] [-o FOLDER]

The scene `docs/remote_trigger.toml`: two minutes on one core, or a run of it that is there. Writes remote_trigger.png.
"""

import argparse
import tempfile
from pathlib import Path

import matplotlib
import numpy as np

import snowmpm
from snowmpm.io import Run

matplotlib.use("Agg")
from matplotlib import pyplot as plt

ROOT = Path(__file__).resolve().parents[2]
SCENE = ROOT / "docs" / "remote_trigger.toml"
CELL = 0.75
"""Of the plan [m]."""


def of_material(frame, number):
    """Which particles are of a material, and where these are (k, 3) [m]."""
    own = np.asarray(frame.fields["material"]).ravel() == number
    return own, np.asarray(frame.positions, float)[own]


def broken_at(run, number, start, corner):
    """Time after `start` [s] at which the first particle of the weak layer in each cell in plan has lost its bonds."""
    found = np.full(np.ceil(np.asarray(corner) / CELL).astype(int), np.nan)
    for i, time in enumerate(run.times):
        frame = run.frame(i)
        own, x = of_material(frame, number)
        cells = (x[np.asarray(frame.fields["damage"]).ravel()[own] > 0.99, :2] / CELL).astype(int)
        cells = cells[(cells < found.shape).all(axis=1)]
        new = np.isnan(found[tuple(cells.T)])
        found[tuple(cells[new].T)] = time - start
    return found


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--run", type=Path)
    parser.add_argument("-o", "--output", type=Path, default=ROOT / "docs" / "figures")
    options = parser.parse_args()
    scene = snowmpm.load_scene(str(SCENE))
    names, load, layer = list(scene.materials), scene.events[0], scene.bodies[0].shape.region
    with tempfile.TemporaryDirectory() as scratch:
        run = Run(options.run) if options.run else snowmpm.run(scene, scratch)
        broken = broken_at(run, names.index("weak_layer"), load.start, scene.domain.max[:2])
        last = run.frame(int(np.abs(np.asarray(run.times) - scene.end_time).argmin()))
        own, x = of_material(last, names.index("slab"))
        speed = np.linalg.norm(np.asarray(last.fields["velocity"])[own], axis=1)
    figure, axes = plt.subplots(2, 1, figsize=(8, 5.6), sharex=True, constrained_layout=True)
    edges = [CELL * np.arange(n + 1) for n in broken.shape]
    shown = axes[0].pcolormesh(*edges, broken.T, cmap="viridis", vmin=0.0)
    figure.colorbar(shown, ax=axes[0], label="s after the load")
    axes[0].plot(*load.centre[:2], "r*", ms=12)
    axes[0].set_title("when the weak layer breaks (star: the load)")
    shown = axes[1].scatter(*x[:, :2].T, c=speed, s=2.5, cmap="magma_r", vmin=0.0)
    figure.colorbar(shown, ax=axes[1], label="m/s")
    axes[1].set_title(f"speed of the slab {scene.end_time - load.start:g} s after the load")
    corners = [(layer.x[i], layer.y[j]) for i, j in ((0, 0), (1, 0), (1, 1), (0, 1), (0, 0))]
    for axis in axes:
        axis.plot(*np.transpose(corners), "c-", lw=1)
        axis.axvline(scene.terrain.points[1][0], color="0.5", ls=":")
        axis.set(aspect="equal", ylabel="y [m]", xlim=(7.0, 60.0), ylim=(1.0, 19.0))
    axes[1].set_xlabel("x [m]: the slope falls towards the dotted line; framed: the weak layer")
    figure.savefig(options.output / "remote_trigger.png", dpi=75)


if __name__ == "__main__":
    main()
