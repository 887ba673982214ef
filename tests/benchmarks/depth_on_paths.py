"""Real paths by columns, by finite volumes and by MPM in three dimensions, with the same friction: run-out, peaks,
seconds.

    python tests/benchmarks/depth_on_paths.py TERRAIN [--runs FOLDER] [--paths avaGar avaAlr] [-o FOLDER]

TERRAIN: folder with AvaFrame's avaGar.asc, avaAlr.tif and their releases. The snow of `avalanche_on_raster`, 2.4 m of
it, Coulomb friction 0.35 of the ground, on cells of 2 m in 3-D and of 5 m in plan, maps of six cells of the elevation
model. The snow has no cohesion, and more inner friction than the ground: it slides, as columns do. One thread,
processor seconds of whole runs. Runs that are complete in FOLDER are read, not made again. Half an hour on one core.
Writes depth_on_paths.csv and depth_on_paths.png.
"""

import argparse
import csv
import tempfile
from pathlib import Path

import matplotlib
import numpy as np

import snowmpm
from snowmpm.io import Run
from snowmpm.terrain.raster import read_raster

matplotlib.use("Agg")
from matplotlib import pyplot as plt

HERE = Path(__file__).parent
PATHS = {"avaGar": ("avaGar.asc", "relGar.shp", 88.0), "avaAlr": ("avaAlr.tif", "relAlr.shp", 160.0)}
"""Elevation model, release, time [s]."""
WAYS = {
    "columns": {"solver.method": "depth", "solver.dx": 5.0, "solver.depth.scheme": "columns"},
    "volumes": {"solver.method": "depth", "solver.dx": 5.0},
    "3-D": {"solver.dx": 2.0},
}
NUMBERS = ("runout", "affected_area", "area_above_10_kPa", "largest_flow_speed", "largest_flow_depth", "deposit_area")


def settings(terrain, path):
    """Of `avalanche_on_raster` on a path."""
    raster, release, end = PATHS[path]
    cell = read_raster(terrain / raster).lattice()[1]
    return {"terrain.file": str(terrain / raster), "bodies.0.shape.region.file": str(terrain / release),
            "bodies.0.shape.top": 2.4, "end_time": end, "output.interval": 2.0, "output.map_cell": 6.0 * cell,
            "materials.snow.youngs_modulus": 1e6, "materials.snow.hardening": 3.0}


def made(folder, changes):
    """The run in a folder, or a new one."""
    if (folder / "summary.json").exists() and Run(folder).complete:
        return Run(folder)
    return snowmpm.run(snowmpm.load_scene("avalanche_on_raster", changes), folder)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("terrain", type=Path)
    parser.add_argument("--runs", type=Path)
    parser.add_argument("--paths", nargs="+", default=list(PATHS))
    parser.add_argument("-o", "--output", type=Path, default=HERE / "figures")
    options = parser.parse_args()
    terrain = options.terrain.resolve()
    snowmpm.start("cpu", threads=1)
    with tempfile.TemporaryDirectory() as temporary:
        folder = (options.runs or Path(temporary)).resolve()
        runs = {path: {way: made(folder / f"{path}_{number}", {**settings(terrain, path), **changes})
                       for number, (way, changes) in enumerate(WAYS.items())} for path in options.paths}
        rows = [{"path": path, "way": way, **{name: round(run.hazard["numbers"][name], 4) for name in NUMBERS},
                 "processor_time": run.summary["processor_time"]}
                for path, ways in runs.items() for way, run in ways.items()]
        with open(options.output / "depth_on_paths.csv", "w", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, list(rows[0]))
            writer.writeheader()
            writer.writerows(rows)
        for row in rows:
            print(row)
        draw(runs, options.output / "depth_on_paths.png")


def draw(runs, path):
    """Peak speeds of each way side by side, with the outline of the affected area of the first."""
    figure, axes = plt.subplots(len(runs), len(WAYS), figsize=(4.2 * len(WAYS), 4.6 * len(runs)), squeeze=False,
                                constrained_layout=True)
    for row, (name, ways) in zip(axes, runs.items(), strict=True):
        first = None
        for axis, (way, run) in zip(row, ways.items(), strict=True):
            speed, depth = run.maps["peak_speed"], run.maps["peak_depth"]
            x = depth.x0 + run.origin[0] + depth.cell * np.arange(depth.values.shape[1])
            y = depth.y0 + run.origin[1] + depth.cell * np.arange(depth.values.shape[0])
            affected = np.nan_to_num(depth.values) >= run.hazard["numbers"]["flow_depth"]
            shown = axis.pcolormesh(x, y, np.where(affected, speed.values, np.nan), vmin=0.0, vmax=60.0, cmap="viridis")
            first = (x, y, affected) if first is None else first
            axis.contour(*first[:2], first[2], levels=[0.5], colors="k", linewidths=0.8)
            j, i = np.nonzero(first[2])
            axis.set(title=f"{name}: {way}", aspect="equal", xlim=(x[i.min()] - 150.0, x[i.max()] + 150.0),
                     ylim=(y[j.min()] - 150.0, y[j.max()] + 150.0))
            axis.ticklabel_format(useOffset=False, style="plain")
            axis.tick_params(labelsize=6)
        figure.colorbar(shown, ax=row, label="peak speed [m/s]; line: affected by columns", shrink=0.8)
    figure.savefig(path, dpi=75)


if __name__ == "__main__":
    main()
