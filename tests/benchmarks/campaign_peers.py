"""A campaign on a real path beside the same runs by AvaFrame's com1DFA: probability maps, run-out distribution.

    python tests/benchmarks/campaign_peers.py TERRAIN --avaframe PYTHON [--runs 100] [--cell 10] [--work FOLDER]
                                              [-o FOLDER]

TERRAIN: folder with avaGar.asc and relGar.shp (AvaFrame's example). Voellmy friction and thickness vary in a Latin
hypercube; com1DFA computes the same rows of friction and thickness, with its own defaults otherwise (samos corrections
off, curvature on), on the same cells, flow density 200 kg/m3 in both. PYTHON: of an environment with `avaframe`. Writes
campaign_peers.csv and campaign_peers.png. Reach: largest plan distance from the middle of the release to a cell whose
peak pressure was 1 kPa or more.
"""

import argparse
import csv
import os
import shutil
import subprocess
from pathlib import Path

import matplotlib
import numpy as np
import pandas

import snowmpm
from snowmpm.io import Run

matplotlib.use("Agg")
from matplotlib import pyplot as plt

HERE = Path(__file__).parent
PRESSURE = 1e3
"""[Pa]"""
PARAMETERS = {
    "mu": {"key": "terrain.friction.mu", "distribution": "uniform", "low": 0.15, "high": 0.35},
    "xi": {"key": "terrain.friction.xi", "distribution": "lognormal", "median": 2000.0, "factor": 1.3},
    "thickness": {"key": "bodies.0.shape.top", "distribution": "normal", "mean": 1.5, "deviation": 0.3, "low": 0.6,
                  "high": 2.4},
}
SCENE = """
name = "avaGar"
dimension = 3
end_time = 400.0
[output]
interval = 20.0
[solver]
method = "depth"
dx = {cell}
[terrain]
kind = "dem"
file = "{terrain}/avaGar.asc"
friction = {{ law = "voellmy", mu = 0.25, xi = 2000.0 }}
[materials.snow]
kind = "elastic"
density = 200.0
youngs_modulus = 1e6
poisson_ratio = 0.3
[[bodies]]
name = "release"
material = "snow"
shape = {{ kind = "layer", bottom = 0.0, top = 1.5, region = {{ file = "{terrain}/relGar.shp" }} }}
"""


def ours(terrain, runs, cell, folder):
    """Our campaign; -> its table, and peak pressures (runs, columns along x, rows along y) with the places of cells."""
    scene = folder / "avaGar.toml"
    scene.write_text(SCENE.format(terrain=terrain, cell=cell))
    campaign = snowmpm.campaign(scene, PARAMETERS, folder / "ours", runs=runs, design="latin_hypercube", seed=1,
                                resume=(folder / "ours" / "plan.json").exists())
    return campaign


def theirs(python, terrain, table, cell, folder):
    """Peak pressures (runs, columns along x, rows along y) [Pa] of com1DFA, places of its cells, processor seconds."""
    here = folder / "avaframe"
    (here / "Inputs" / "REL").mkdir(parents=True, exist_ok=True)
    shutil.copy(terrain / "avaGar.asc", here / "Inputs" / "dem.asc")
    for file in terrain.glob("relGar.*"):
        shutil.copy(file, here / "Inputs" / "REL" / f"release{file.suffix}")
    rows = folder / "rows.csv"
    table[["run", *PARAMETERS]].to_csv(rows, index=False)
    out = folder / "com1dfa.npz"
    subprocess.run([python, HERE / "peers" / "avaframe_campaign.py", here, rows, str(cell), out], check=True,
                   cwd=folder, env={**os.environ, "OMP_NUM_THREADS": "1"})
    found = np.load(out)
    pressure = found["pressure"][:, ::-1].transpose(0, 2, 1)
    corner, cell = found["corner"], float(found["cell"])
    x = corner[0] + cell * (np.arange(pressure.shape[1]) + 0.5)
    y = corner[1] - cell * (np.arange(pressure.shape[2])[::-1] + 0.5)
    return pressure, x, y, found["seconds"]


def reach(pressure, x, y, middle):
    """Largest plan distance [m] from `middle` to a cell above `PRESSURE`, of each run."""
    away = np.hypot(x[:, None] - middle[0], y[None] - middle[1])
    return np.array([away[one >= PRESSURE].max(initial=0.0) for one in pressure])


def on(x, y, pressure, to_x, to_y):
    """Values of the nearest cells at other places."""
    i = np.abs(x[:, None] - to_x).argmin(axis=0)
    j = np.abs(y[:, None] - to_y).argmin(axis=0)
    return pressure[:, i][:, :, j]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("terrain", type=Path)
    parser.add_argument("--avaframe", required=True)
    parser.add_argument("--runs", type=int, default=100)
    parser.add_argument("--cell", type=float, default=10.0, help="[m]")
    parser.add_argument("--work", type=Path, default=Path("campaign_peers"))
    parser.add_argument("-o", "--output", type=Path, default=HERE / "figures")
    options = parser.parse_args()
    terrain, folder = options.terrain.resolve(), options.work.resolve()
    folder.mkdir(parents=True, exist_ok=True)
    campaign = ours(terrain, options.runs, options.cell, folder)
    table = pandas.read_csv(folder / "ours" / "table.csv")
    own = []
    for number in table["hash"]:
        run = Run(folder / "ours" / "runs" / number)
        peak = run.maps["peak_pressure"]
        own.append(np.nan_to_num(peak.values).T)
    own, cell = np.array(own), peak.cell
    x, y = (first + run.origin[axis] + cell * np.arange(own.shape[1 + axis])
            for axis, first in enumerate((peak.x0, peak.y0)))
    release = np.nan_to_num(run.maps["release_depth"].values).T
    middle = np.array([(release.sum(axis=1) @ x), (release.sum(axis=0) @ y)]) / release.sum()
    other, ox, oy, seconds = theirs(options.avaframe, terrain, table, options.cell, folder)
    other = on(ox, oy, other, x, y)
    work = pandas.read_csv(folder / "ours" / "work.csv")
    report(campaign, own, other, x, y, cell, middle, work, seconds, options.output)


def report(campaign, own, other, x, y, cell, middle, work, seconds, output):
    """Table and picture."""
    chance = [np.mean(each >= PRESSURE, axis=0) for each in (own, other)]
    reaches = [reach(each, x, y, middle) for each in (own, other)]
    areas = [cell**2 * (each >= PRESSURE).sum(axis=(1, 2)) for each in (own, other)]
    likely = [each >= 0.5 for each in chance]
    touched = (chance[0] > 0.0) | (chance[1] > 0.0)
    rows = []
    for name, i in (("snowmpm depth", 0), ("AvaFrame com1DFA", 1)):
        row = {"program": name, "runs": len(own)}
        for share in (5, 50, 95):
            row[f"reach_{share}"] = round(float(np.percentile(reaches[i], share)), 1)
        row["area_50"] = round(float(np.median(areas[i])))
        row["area_likely"] = round(float(cell**2 * likely[i].sum()))
        row["processor_seconds_a_run"] = round(float([work.processor_time.mean(), seconds.mean()][i]), 2)
        rows.append(row)
    rows[1].update(
        correlation_of_reach=round(float(np.corrcoef(*reaches)[0, 1]), 4),
        mean_difference_of_probability=round(float(np.abs(chance[0] - chance[1])[touched].mean()), 4),
        overlap_of_likely_area=round(float((likely[0] & likely[1]).sum() / (likely[0] | likely[1]).sum()), 4))
    with open(output / "campaign_peers.csv", "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, list(rows[1]))
        writer.writeheader()
        writer.writerows(rows)
    for row in rows:
        print(row)
    figure, axes = plt.subplots(1, 3, figsize=(13, 5), constrained_layout=True)
    where = np.argwhere(touched)
    low, high = where.min(axis=0) - 5, where.max(axis=0) + 5
    window = slice(max(0, low[0]), high[0]), slice(max(0, low[1]), high[1])
    extent = [x[window[0]][0], x[window[0]][-1], y[window[1]][0], y[window[1]][-1]]
    for axis, each, title in zip(axes, chance, ("snowmpm depth", "AvaFrame com1DFA"), strict=False):
        shown = axis.imshow(np.where(each > 0.0, each, np.nan)[window].T, origin="lower", extent=extent, vmin=0, vmax=1,
                            cmap="viridis")
        axis.contour(each[window].T, levels=[0.5], colors="k", linewidths=0.8, extent=extent)
        axis.set_title(title)
        axis.ticklabel_format(useOffset=False, style="plain")
        axis.tick_params(labelsize=7)
    figure.colorbar(shown, ax=axes[:2], label="share of runs above 1 kPa", shrink=0.8)
    bins = np.linspace(min(map(np.min, reaches)), max(map(np.max, reaches)), 20)
    axes[2].hist(reaches, bins, label=["snowmpm depth", "com1DFA"])
    axes[2].set_xlabel("reach of 1 kPa from the middle of the release [m]")
    axes[2].set_ylabel("runs")
    axes[2].legend()
    figure.savefig(output / "campaign_peers.png", dpi=80)


if __name__ == "__main__":
    main()
