"""MPM and SPH on the same scenes: error, time and particles at three resolutions each, as CSV and chart.

    python tests/benchmarks/two_methods.py [-o FOLDER] [--only WORD] [--runs DIR]

Each scene of the library that has a known answer, with particles at the same three distances in both methods: SPH has
one a cell, MPM four, so its cells are twice as wide. The sand is as soft as its law allows, on which the answers do
not depend; MPM moves grains by aflip, the beam by apic, as the scenes say; SPH as by default.

All on one thread. error: root mean square of the relative errors of the numbers that `snowmpm compare` finds (run-out
and height; depth and time of a swing; axial stress, stress ratio, stress on the cover); that of the columns is against
a law of experiments, which no resolution takes away. The thrust of flume_impact has bounds and no value: its error is
the distance from the mean thrust of both methods at half the finest spacing, runs of which only that is used. time:
processor time of all steps, at the pace of those after the first report, which had kernels to compile; other work on
the machine makes it longer by a part, where it would multiply wall time. Runs that are in DIR already are taken as
they are, with the time that they took.
"""

import argparse
import csv
import itertools
import json
import time
from pathlib import Path

import numpy as np

import snowmpm
from snowmpm.comparison import Case
from snowmpm.comparison.answers import answer_of
from snowmpm.compiler import runtime
from snowmpm.scenes import load_scene

METHODS = ("mpm", "sph")
SCENES = {  # distances of particles [m], and what is changed in the scene
    "column_collapse_2d": ((0.2 / 15, 0.2 / 30, 0.2 / 60), {"materials.sand.youngs_modulus": 5.04e5, "end_time": 0.8}),
    "column_collapse_3d": ((0.2 / 6, 0.2 / 8, 0.2 / 12), {"materials.sand.youngs_modulus": 5.04e5, "end_time": 0.7}),
    "sand_between_plates": ((0.1 / 8, 0.1 / 12, 0.1 / 20), {"end_time": 0.6}),
    "elastic_beam": ((0.1 / 4, 0.1 / 8, 0.1 / 16), {"end_time": 1.2}),
    "oedometer": ((0.5 / 8, 0.5 / 10, 0.5 / 14), {}),
    "flume_impact": ((0.3 / 12, 0.3 / 18, 0.3 / 36), {"materials.sand.youngs_modulus": 5.4e5, "end_time": 2.0}),
}
COLUMNS = ("scene", "method", "particle_spacing_m", "particles", "steps", "time_s", "ns_per_particle_step", "error",
           "numbers")
OWN_SCALE = "flume_impact"


class Pace:
    """Processor time of a run's steps without what their first ones compile, told when it reports its progress."""

    def __init__(self):
        self._reports = []

    def __call__(self, progress):
        self._reports.append((time.process_time(), progress.steps))

    def time(self, steps):
        """Of that many steps [s]."""
        (begin, first), (end, last) = self._reports[0], self._reports[-1]
        return (end - begin) / (last - first) * steps if last > first else end


def case_of(scene, method, spacing, folder):
    """The run of one row, made if it is not there, and the time of its steps [s]."""
    changes = SCENES[scene][1] | {"solver.method": method, "solver.dx": spacing if method == "sph" else 2.0 * spacing}
    kept = folder / "pace.json"
    if not kept.exists():
        pace = Pace()
        run = snowmpm.run(load_scene(scene, changes), folder, progress=pace)
        kept.write_text(json.dumps({"time": pace.time(run.summary["steps"])}))
    return Case(f"{scene} {method}", snowmpm.Run(folder)), json.loads(kept.read_text())["time"]


def row(scene, method, spacing, folder):
    case, taken = case_of(scene, method, spacing, folder)
    summary, found = case.run.summary, answer_of(case).quantities()
    scaled = [quantity for quantity in found if quantity.low * quantity.high > 0.0]
    error = float(np.sqrt(np.mean([quantity.error**2 for quantity in scaled])))
    numbers = "; ".join(f"{quantity.name} {quantity.measured:.4g} {quantity.unit} ({100 * quantity.error:+.1f} %)"
                        for quantity in scaled)
    return {"scene": scene, "method": method, "particle_spacing_m": f"{spacing:.4g}", "particles": summary["particles"],
            "steps": summary["steps"], "time_s": f"{taken:.2f}",
            "ns_per_particle_step": f"{1e9 * taken / summary['particle_steps']:.0f}", "error": f"{error:.3e}",
            "numbers": numbers, "first": scaled[0].measured}


def give_scale(rows, folder):
    """Errors of the scene that has no value to be held against: from the mean of both methods, twice as fine."""
    own = [one for one in rows if one["scene"] == OWN_SCALE]
    spacing = 0.5 * SCENES[OWN_SCALE][0][-1]
    if own:
        mean = np.mean([row(OWN_SCALE, method, spacing, folder / f"{OWN_SCALE}_{method}_scale")["first"]
                        for method in METHODS])
    for one in own:
        one["error"] = f"{abs(one['first'] / mean - 1.0):.3e}"
        one["numbers"] = f"thrust at rest {one['first']:.4g} N/m ({100.0 * (one['first'] / mean - 1.0):+.1f} %)"


def draw(rows, file):
    """Error over time, a panel a scene, a line a method; beside each point its particles."""
    from matplotlib.figure import Figure
    from matplotlib.ticker import LogLocator, NullFormatter, StrMethodFormatter

    from snowmpm.render.figure import plain, save

    scenes = list(dict.fromkeys(one["scene"] for one in rows))
    across = min(3, len(scenes))
    down = -(-len(scenes) // across)
    figure = Figure(figsize=(4.2 * across, 3.8 * down), layout="constrained")
    places = figure.subplots(down, across, squeeze=False).ravel()
    for axes in places[len(scenes) :]:
        axes.remove()
    for axes, scene in zip(places, scenes, strict=False):
        plain(axes)
        for method, colour in zip(METHODS, ("#1d4f91", "#d9642a"), strict=True):
            own = [one for one in rows if (one["scene"], one["method"]) == (scene, method)]
            if not own:
                continue
            taken, error = ([float(one[name]) for one in own] for name in ("time_s", "error"))
            axes.loglog(taken, 100.0 * np.array(error), "o-", color=colour, lw=1.6, label=method.upper())
            for one, x, y in zip(own, taken, error, strict=True):
                axes.annotate(f"{one['particles']:,}".replace(",", " "), (x, 100.0 * y), xytext=(5, 5),
                              textcoords="offset points", fontsize=7, color=colour)
        axes.margins(0.2)
        for axis in (axes.xaxis, axes.yaxis):
            axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
            axis.set_major_formatter(StrMethodFormatter("{x:g}"))
            axis.set_minor_formatter(NullFormatter())
        axes.set_title(scene.replace("_", " "), loc="left", fontsize=10)
        axes.set_xlabel("processor time of the steps  [s]")
        axes.set_ylabel("error  [%]")
        axes.legend(frameon=False, fontsize=9)
    figure.suptitle("MPM and SPH on the same scenes, one thread; numbers of particles at the points")
    save(figure, file, 110)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("-o", "--output", type=Path, default=Path(__file__).parent / "figures", help="folder")
    parser.add_argument("--only", default="", help="scenes whose name holds this")
    parser.add_argument("--runs", type=Path, default=Path("runs/two_methods"), help="folder of the runs")
    options = parser.parse_args()
    runtime.start("cpu", threads=1)
    options.output.mkdir(parents=True, exist_ok=True)
    rows = []
    for scene, level, method in itertools.product(SCENES, range(3), METHODS):
        if options.only in scene:
            folder = options.runs / f"{scene}_{method}_{level}"
            rows.append(row(scene, method, SCENES[scene][0][level], folder))
            print(*(rows[-1][name] for name in COLUMNS), flush=True)
    rows.sort(key=lambda one: (list(SCENES).index(one["scene"]), one["method"]))
    give_scale(rows, options.runs)
    with open(options.output / "two_methods.csv", "w", newline="") as lines:
        writer = csv.DictWriter(lines, COLUMNS, extrasaction="ignore")
        writer.writeheader()
        writer.writerows(rows)
    draw(rows, options.output / "two_methods.png")


if __name__ == "__main__":
    main()
