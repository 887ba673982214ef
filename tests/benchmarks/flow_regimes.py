"""The four flow regimes on one slope: fronts, velocity over the depth, pieces, plastic share (S5).

    python tests/benchmarks/flow_regimes.py [-o FOLDER] [--dx 0.1] [--runs FOLDER]

runs the library scenes flow_* (or takes the runs named FOLDER/flow_*), writes flow_regimes.csv and flow_regimes.png to
tests/benchmarks/figures or FOLDER, and prints the table.
"""

import argparse
import csv
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from scipy import ndimage

import snowmpm
from snowmpm.io import Run
from snowmpm.render.figure import plain, save

SCENES = {"I cold dense": "flow_cold_dense", "II warm shear": "flow_warm_shear",
          "III sliding slab": "flow_sliding_slab", "IV warm plug": "flow_warm_plug"}
PUBLISHED = {"I cold dense": 0.772, "II warm shear": 0.258, "III sliding slab": 0.104, "IV warm plug": 0.340}
"""Plastic share at 10 s of Li et al. (2021), table 1, on a slope of their own."""
COLOURS = ("#1d4f91", "#3a8a5c", "#d9642a", "#7d1c6d")
ANGLE, FRICTION, LENGTH = np.radians(35.0), 0.47, 100.0
TOE = LENGTH * np.cos(ANGLE)
"""Where the arc begins, x [m]."""
BROKEN = 0.9
"""Share of the strength whose loss is a crack."""


def slope_height(x):
    """Height of the inclined plane [m]; the scenes' first corner."""
    return 62.78 - np.tan(ANGLE) * x


def front(run):
    """x of the front of each history row [m]: 99.5 % of the moving snow lies behind it."""
    start = run.frame(0, []).points[:, 0].mean()
    return np.where(run.history["front"] > 0.0, start + run.history["front"], start)


def block_excess(run, drop=0.005):
    """Largest speed of the front on the slope over that of a sliding block, sqrt(2 g s (sin - mu cos)), where s is the
    way of the front along the slope, once it has gone ten metres."""
    x = np.array([np.quantile(run.frame(i, []).points[:, 0], 1.0 - drop) for i in range(len(run))])
    s = (x - x[0]) / np.cos(ANGLE)
    speed = np.gradient(s, run.times)
    on = (s > 10.0) & (x < TOE)
    bound = np.sqrt(2.0 * 9.81 * s[on] * (np.sin(ANGLE) - FRICTION * np.cos(ANGLE)))
    return float((speed[on] / bound).max())


def depth_profile(run, time, bins=10):
    """Height over the bed [m] and mean velocity along the slope [m/s] in the middle fifth of the snow on the slope."""
    i = int(np.abs(run.times - time).argmin())
    frame = run.frame(i, ["velocity"])
    x, z = frame.points[:, 0] + run.origin[0], frame.points[:, 2] + run.origin[2]
    height = (z - slope_height(x)) * np.cos(ANGLE)
    low, high = np.quantile(x, [0.4, 0.6])
    inside = (x > low) & (x < high) & (x < TOE)
    along = frame.fields["velocity"][:, 0] * np.cos(ANGLE) - frame.fields["velocity"][:, 2] * np.sin(ANGLE)
    ends = np.linspace(0.0, np.quantile(height[inside], 0.98) if inside.any() else 1.0, bins + 1)
    count = np.histogram(height[inside], ends)[0]
    mean = np.histogram(height[inside], ends, weights=along[inside])[0] / np.maximum(count, 1)
    return 0.5 * (ends[1:] + ends[:-1]), np.where(count > 0, mean, np.nan)


def pieces(run, time):
    """Areas [m2] of the connected pieces of unbroken snow, largest first: grid cells at least half full of particles
    with more than 1 - BROKEN of their strength, joined over their sides."""
    i = int(np.abs(run.times - time).argmin())
    frame, dx = run.frame(i, ["damage"]), run.provenance["dx"]
    whole = frame.fields["damage"] < BROKEN
    cells = np.floor(frame.points[whole][:, [0, 2]] / dx).astype(int)
    if not len(cells):
        return np.zeros(0)
    cells -= cells.min(axis=0)
    count = np.zeros(cells.max(axis=0) + 1)
    np.add.at(count, tuple(cells.T), 1.0)
    full = count * run.provenance["particle_spacing"] ** 2 >= 0.5 * dx**2
    labels, n = ndimage.label(full)
    return np.sort(ndimage.sum_labels(full, labels, np.arange(1, n + 1)))[::-1] * dx**2


def cracks(run, time):
    """Share of the snow that has lost its strength."""
    i = int(np.abs(run.times - time).argmin())
    return float((run.frame(i, ["damage"]).fields["damage"] >= BROKEN).mean())


def plastic_share(run, time=10.0, over=0.5):
    near = np.abs(run.history["time"] - time) <= over
    return float(run.history["plastic_fraction"][near].mean())


def measured(run, regime):
    """One row of the table."""
    x, dx = front(run), run.provenance["dx"]
    area = pieces(run, run.times[-1])
    granules = area[area >= 4.0 * dx**2]
    sizes = np.sqrt(granules)
    speed = np.linalg.norm(run.frame(-1, ["velocity"]).fields["velocity"], axis=1)
    return {
        "regime": regime, "front_at_8_s": float(np.interp(8.0, run.history["time"], x)), "front_at_rest": float(x[-1]),
        "front_over_block": block_excess(run), "plastic_share": plastic_share(run),
        "published_share": PUBLISHED[regime], "broken_share": cracks(run, run.times[-1]),
        "pieces": len(granules), "largest_piece_m2": float(area[0]) if len(area) else 0.0,
        "size_of_pieces_m": float((granules @ sizes) / granules.sum()) if len(granules) else 0.0,
        "moving_at_the_end": float((speed > 0.1).mean()),
        "wall_time_s": run.summary.get("wall_time", float("nan")), "particles": run.n_points(0),
    }


def draw(runs, output):
    figure = Figure(figsize=(11.0, 7.6), dpi=130, layout="constrained")
    fronts, profiles, plastic, sizes = figure.subplots(2, 2).ravel()
    for colour, (regime, run) in zip(COLOURS, runs.items(), strict=True):
        fronts.plot(run.history["time"], front(run), color=colour, lw=1.8, label=regime)
        x = front(run)
        time = float(np.interp(0.75 * TOE, np.maximum.accumulate(x), run.history["time"]))
        height, speed = depth_profile(run, time)
        profiles.plot(speed / np.nanmax(speed), height, "o-", color=colour, lw=1.6, ms=4,
                      label=f"{regime}, {time:.1f} s, {np.nanmax(speed):.1f} m/s")
        plastic.plot(run.history["time"], 100.0 * run.history["plastic_fraction"], color=colour, lw=1.2)
        plastic.plot(10.0, 100.0 * PUBLISHED[regime], "D", color=colour, ms=6)
        area = pieces(run, run.times[-1])
        if len(area):
            sizes.step(np.sqrt(area), np.cumsum(area) / area.sum(), color=colour, lw=1.6, where="post")
    fronts.axhline(TOE, color="0.6", lw=0.8, ls=":")
    for axes, title, x, y in ((fronts, "front (dotted: where the arc begins)", "time  [s]", "x  [m]"),
                              (profiles, "velocity over the depth, front at three quarters of the slope",
                               "share of the largest", "height over the bed  [m]"),
                              (plastic, "plastic snow (diamonds: published)", "time  [s]", "share  [%]"),
                              (sizes, "unbroken pieces at the end", "size, root of the area  [m]",
                               "share of unbroken snow in pieces as large")):
        plain(axes)
        axes.set_title(title, loc="left", fontsize=10)
        axes.set_xlabel(x)
        axes.set_ylabel(y)
    sizes.set_xscale("log")
    sizes.set_xticks([0.2, 0.5, 1.0, 2.0, 5.0], ["0.2", "0.5", "1", "2", "5"], minor=False)
    sizes.xaxis.set_minor_formatter("")
    profiles.set_xlim(left=0.0)
    fronts.legend(fontsize=8, edgecolor="none")
    profiles.legend(fontsize=8, edgecolor="none")
    return save(figure, output, 130)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("-o", "--output", type=Path, default=Path(__file__).with_name("figures"))
    parser.add_argument("--dx", type=float, default=0.1)
    parser.add_argument("--runs", type=Path)
    chosen = parser.parse_args()
    runs = {}
    for regime, name in SCENES.items():
        if chosen.runs:
            runs[regime] = Run(next(iter(sorted(chosen.runs.glob(f"{name}*/run.vtkhdf")))))
        else:
            scene = snowmpm.load_scene(name, {"solver.dx": chosen.dx, "solver.cfl": 0.7})
            runs[regime] = snowmpm.run(scene, chosen.output / "runs" / name)
    rows = [measured(run, regime) for regime, run in runs.items()]
    chosen.output.mkdir(parents=True, exist_ok=True)
    with open(chosen.output / "flow_regimes.csv", "w", newline="", encoding="utf-8") as file:
        table = csv.DictWriter(file, rows[0], lineterminator="\n")
        table.writeheader()
        table.writerows({name: f"{v:.4g}" if isinstance(v, float) else v for name, v in row.items()} for row in rows)
    for row in rows:
        print({name: round(value, 3) if isinstance(value, float) else value for name, value in row.items()})
    print(draw(runs, chosen.output / "flow_regimes.png"))


if __name__ == "__main__":
    main()
