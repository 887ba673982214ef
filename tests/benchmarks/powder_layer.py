"""How far the powder layer's answers depend on each of its closures: one avalanche, one closure at a time.

    python tests/benchmarks/powder_layer.py [--only TEXT]     writes figures/powder_layer.csv, 2 minutes
    python tests/benchmarks/powder_layer.py --draw            draws docs/figures/powder_layer.png from it

The avalanche of the library scene avalanche_depth_averaged, 39 400 m3 in a made-up valley, for 60 s. reach: distance in
plan from the highest cell of the release to the furthest cell in which the cloud's rho u^2 (means over its height) once
was at least so much; flow_reach: the same of the flow at 0.1 m or more. No measured avalanche stands behind any of it.
"""

import argparse
import csv
import sys
from pathlib import Path

import numpy as np

import snowmpm
from snowmpm.scenes import load_scene
from snowmpm.scenes.loader import with_overrides

HERE = Path(__file__).resolve().parent
TABLE = HERE / "figures" / "powder_layer.csv"
PICTURE = HERE.parents[1] / "docs" / "figures" / "powder_layer.png"
END, DEEP, MARGIN = 60.0, 0.1, 4
VARIANTS = {
    "usual": {},
    "air_entrainment = parker_1987": {"air_entrainment": "parker_1987"},
    "air_entrainment = none": {"air_entrainment": "none"},
    "suspension_rate x 1/2": {"suspension_rate": 5e-4},
    "suspension_rate x 2": {"suspension_rate": 2e-3},
    "suspension = shear_excess": {"suspension": "shear_excess"},
    "cover_load = 20 kg/m2": {"cover_load": 20.0},
    "grain_diameter = 0.1 mm": {"grain_diameter": 1e-4},
    "grain_diameter = 0.5 mm": {"grain_diameter": 5e-4},
    "fall_speed = 0.5 m/s": {"fall_speed": 0.5},
    "bed_concentration = uniform": {"bed_concentration": "uniform"},
    "core_drag x 1/2": {"core_drag": 0.02},
    "core_drag x 2": {"core_drag": 0.08},
    "ground_drag x 1/2": {"ground_drag": 0.004},
    "ground_drag x 2": {"ground_drag": 0.016},
    "top_drag = 0": {"top_drag": 0.0},
    "top_drag x 10": {"top_drag": 1e-3},
    "front_drag = 0": {"front_drag": 0.0},
    "front_drag x 2": {"front_drag": 1.0},
    "profile = motpsa": {"profile": "motpsa"},
    "cells of 10 m": {"dx": 10.0},
    "cells of 2.5 m": {"dx": 2.5},
}


def measured(options):
    """A row of the table."""
    options = dict(options)
    dx = options.pop("dx", 5.0)
    scene = with_overrides(load_scene("avalanche_depth_averaged"), {"powder_layer": options, "solver.dx": dx})
    simulation = snowmpm.Simulation(scene)
    solver = simulation.solver
    store, adapter = solver.particles, solver.adapters["powder_layer"]
    cloud, inner = adapter.cloud, store.inner
    wet = inner(store.state_array)[..., 0] > 0.0
    heights = np.where(wet, inner(solver.heights), -np.inf)
    top = solver.grid.places()[np.unravel_index(heights.argmax(), heights.shape)]
    distance, flowed, most = np.linalg.norm(solver.grid.places() - top, axis=-1), wet.copy(), 0.0
    while simulation.time < END:
        simulation.step(END)
        flowed |= inner(store.state_array)[..., 0] > DEEP
        most = max(most, cloud.ice_mass)
    peaks, row = inner(cloud.peaks), adapter.row()
    reach = {f"reach_{least:g}_kpa": float(distance[peaks[..., 1] >= 1e3 * least].max(initial=0.0))
             for least in (1, 3, 5)}
    return {**reach, "flow_reach": float(distance[flowed].max()), "pressure_kpa": float(peaks[..., 1].max()) / 1e3,
            "foot_pressure_kpa": float(peaks[..., 2].max()) / 1e3, "speed": float(peaks[..., 3].max()),
            "height": float(peaks[..., 0].max()), "most_ice_t": most / 1e3, "suspended_t": row["suspended_mass"] / 1e3,
            "air_taken_in_m3": row["cloud_air_taken_in"], "flow_mass_t": store.mass / 1e3, "steps": solver.steps}


def written(only):
    """Measure and write the table; only: part of the names of those to measure anew."""
    rows = read() if only and TABLE.exists() else {}
    for name, options in VARIANTS.items():
        if not only or only in name or name not in rows:
            rows[name] = {key: f"{value:.5g}" for key, value in measured(options).items()}
            print(name, rows[name], flush=True)
    with TABLE.open("w", newline="", encoding="utf-8") as file:
        table = csv.DictWriter(file, ["variant", *rows["usual"]], lineterminator="\n")
        table.writeheader()
        table.writerows({"variant": name, **rows[name]} for name in VARIANTS)


def read():
    """The table: variant -> its row."""
    with TABLE.open(newline="", encoding="utf-8") as file:
        return {row.pop("variant"): row for row in csv.DictReader(file)}


def draw():
    """Reach of 1 kPa and largest pressure of each variant, beside those of the usual one."""
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    rows = read()
    names = list(rows)[::-1]
    figure, axes = plt.subplots(1, 2, figsize=(9.0, 5.2), sharey=True, layout="constrained")
    told = (("reach_1_kpa", "reach of 1 kPa [m]"), ("pressure_kpa", "largest pressure [kPa]"))
    for axis, (column, label) in zip(axes, told, strict=True):
        values, usual = [float(rows[name][column]) for name in names], float(rows["usual"][column])
        axis.barh(names, [value - usual for value in values], left=usual, height=0.6,
                  color=["#b2182b" if value > usual else "#2166ac" for value in values])
        axis.axvline(usual, color="black", linewidth=1.0)
        if column.startswith("reach"):
            flow = float(rows["usual"]["flow_reach"])
            axis.axvline(flow, color="0.5", linewidth=1.0, linestyle="--")
            axis.annotate("flow, 0.1 m ", (flow, len(names) - 0.9), color="0.4", ha="right", fontsize=8)
        axis.set_xlabel(label)
        axis.grid(axis="x", color="0.9")
        axis.set_axisbelow(True)
    figure.suptitle("Powder layer, an experiment: one closure changed at a time", fontsize=11)
    figure.savefig(PICTURE, dpi=100)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", default="", metavar="TEXT")
    parser.add_argument("--draw", action="store_true")
    given = parser.parse_args()
    sys.exit(draw() if given.draw else written(given.only))
