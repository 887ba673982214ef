"""Experiments on dry grains by MPM and by SPH, beside what was published: columns, flume, bars, loose against dense.

    python tests/benchmarks/granular_experiments.py [--only GROUP ...] [--runs FOLDER] [-o FOLDER]

Groups: plane (16 columns), flume (7 runs), bars, plates, packing, round (10 columns in 3-D). One setting a method
in all cases of a group, named in the table; nothing is changed for a case but what the experiment changed. Runs that
are complete in FOLDER are read, not made again. About twenty minutes on one core. Writes
granular_experiments.csv and .png; of groups that were not asked for, the rows stay.
"""

import argparse
import csv
import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path

import matplotlib
import numpy as np

import snowmpm
from snowmpm.comparison import Case
from snowmpm.comparison.answers import answer_of
from snowmpm.comparison.answers.column import plane_height, plane_runout, round_height, round_runout
from snowmpm.comparison.profile import profile
from snowmpm.io import Run

matplotlib.use("Agg")
from matplotlib import pyplot as plt

HERE = Path(__file__).parent
GRANULAR = {"mpm": {"solver.transfer": "aflip", "solver.flip_ratio": 0.99, "solver.sampling": "poisson"}, "sph": {}}
SOFT = 5.04e5
"""Young's modulus [Pa] of the sand of columns, a fortieth of the published one, on which nothing depends."""
SAND = {"materials.sand": {
    "kind": "critical_state_hypoplastic", "density": 1800.0, "youngs_modulus": 1e6, "reference_pressure": 5e3,
    "poisson_ratio": 0.0, "friction_angle": 30.0, "least_void_ratio": 0.5, "critical_void_ratio_limit": 0.55,
    "critical_void_ratio_drop": 0.25, "density_effect": 0.2}}
"""Sand that knows its density: friction of 30 degrees at its critical state, loose or dense."""
PLANE = (0.5, 1.0, 1.5, 2.0, 4.0, 6.0, 8.0, 10.0)
ROUND = (0.5, 0.55, 0.9, 1.0, 2.0, 4.0)
WINDOW, BREADTH = 0.1, 0.3
"""Time over which the largest force is a mean [s]; width of the flume [m]."""


@dataclass(frozen=True)
class Experiment:
    """A library scene with changes; spacing of particles [m] by method: cells are twice as wide; known: what of its
    numbers is published, as (lowest, highest)."""

    group: str
    name: str
    scene: str
    spacing: dict
    changes: dict = field(default_factory=dict)
    known: dict = field(default_factory=dict)

    def case(self, method, folder):
        """`Case` of its run in the folder, which is made unless it is there, and processor seconds (nan: was there)."""
        spacing, place = self.spacing[method], folder / f"{self.group}_{self.name}_{method}".replace(" ", "_")
        spent = np.nan
        if not ((place / "summary.json").exists() and Run(place).complete):
            numerics = {"solver.method": method, "solver.dx": spacing if method == "sph" else 2.0 * spacing,
                        "output.interval": 0.05, **GRANULAR[method]}
            begun = time.process_time()
            snowmpm.run(snowmpm.load_scene(self.scene, {**self.changes, **numerics}), place, resume=False)
            spent = time.process_time() - begun
        return Case(method, Run(place)), spent


def plane(a, angle):
    d0, h0 = (0.4, 0.2) if a == 0.5 else (0.2, 0.2 * a)
    changes = {"bodies.0.shape.max": [d0, h0], "materials.sand.friction_angle": angle, "end_time": 2.0,
               "materials.sand.youngs_modulus": SOFT, "domain.max": [2.6, 2.4]}
    low, high = plane_height(a)
    known = {"run-out": 2 * (d0 * (1.0 + plane_runout(a)),), "height of the middle": (low * d0, high * d0)}
    return Experiment("plane", f"a {a:g}, {angle:g} deg", "column_collapse_2d", {"mpm": 0.01, "sph": 0.02}, changes,
                      known)


def round_column(a, angle):
    reach = 0.2 * (2.0 + 1.3 * round_runout(a))
    changes = {"bodies.0.shape.height": 0.2 * a, "materials.sand.friction_angle": angle, "end_time": 1.2,
               "materials.sand.youngs_modulus": SOFT, "domain.min": [-reach, -reach, -0.1],
               "domain.max": [reach, reach, 0.2 * a + 0.2]}
    low, high = round_height(a)
    known = {"run-out": 2 * (0.2 * (1.0 + round_runout(a)),), "height of the middle": (0.2 * low, 0.2 * high)}
    return Experiment("round", f"a {a:g}, {angle:g} deg", "column_collapse_3d", {"mpm": 0.0125, "sph": 0.025}, changes,
                      known)


def flume(inclination, angle):
    slope = np.radians(inclination)
    changes = {"gravity": [9.81 * float(np.sin(slope)), -9.81 * float(np.cos(slope))], "end_time": 2.0,
               "materials.sand.friction_angle": angle, "materials.sand.youngs_modulus": 5.4e5,
               "obstacles.1.shape.max": [1.9, 0.3]}  # the wall, over which sand spills
    return Experiment("flume", f"{inclination} deg, sand {angle:g} deg", "flume_impact", {"mpm": 0.0125, "sph": 0.0125},
                      changes)


def columns_of(group, name, known, changes, spacing=0.0025):
    """A column 0.2 m wide and 0.1 m high."""
    shape = {"bodies.0.shape.max": [0.2, 0.1], "end_time": 1.0, "domain.max": [0.8, 0.3], "domain.min": [0.0, -0.04]}
    scene = "sand_between_plates" if group == "plates" else "column_collapse_2d"
    return Experiment(group, name, scene, {"mpm": spacing, "sph": 2.0 * spacing}, {**shape, **changes}, known)


def experiments():
    """All of them."""
    return [
        *(plane(a, angle) for a in PLANE for angle in (33.0, 37.0)),
        *(flume(45, angle) for angle in (33.0, 35.0, 44.0)), *(flume(i, 35.0) for i in (50, 55, 60, 65)),
        columns_of("bars", "aluminium bars", {"height of the middle": (0.1, 0.1)},
                   {"materials.sand": {"card": "aluminium_bars"}}),
        columns_of("plates", "hypoplastic sand", {"run-out": (0.36, 0.40), "height of the middle": (0.1, 0.1)}, {}),
        *(columns_of("packing", name, {}, {"materials.sand": SAND["materials.sand"] | {"void_ratio": e}})
          for name, e in (("loose", 0.84), ("dense", 0.60))),
        *(round_column(a, angle) for a in ROUND for angle in ((37.0,) if a in (0.55, 0.9) else (33.0, 37.0))),
    ]


def measured(experiment, case):
    """{quantity: (unit, value)} of a run."""
    answer = answer_of(case)
    if experiment.group == "flume":
        wall = case.run.obstacles["wall"]
        begin = np.arange(0.0, wall.time[-1] - WINDOW, 0.01)
        impulse = np.interp(begin + WINDOW, wall.time, wall.impulse[:, 0]) - np.interp(begin, wall.time,
                                                                                      wall.impulse[:, 0])
        low, high = answer.bounds()
        return {"largest force": ("N", BREADTH * float(impulse.max()) / WINDOW),
                "thrust at rest": ("N", BREADTH * answer.thrust()),
                "least thrust of wedges": ("N", BREADTH * low), "largest thrust of wedges": ("N", BREADTH * high)}
    found = {quantity.name: (quantity.unit, quantity.measured) for quantity in answer.quantities()}
    if experiment.group == "round":
        top = profile(case, case.run.frame(-1), answer.centre())
        height = case.body["shape"]["height"]
        lowered = top.s[top.top < height - 0.5 * case.spacing]
        found["radius of the top as it was"] = ("m", float(lowered.min()) - case.spacing if len(lowered) else 0.2)
    if experiment.group == "packing":
        half = int(np.searchsorted(case.run.times, 0.2))
        found["front after 0.2 s"] = ("m", profile(case, case.run.frame(half)).front)
        found["largest kinetic energy"] = ("J/m", float(case.run.history["kinetic_energy"].max()))
    return found


def table(chosen, folder):
    """A row for each experiment, method and quantity."""
    for experiment in chosen:
        for method in ("mpm", "sph"):
            case, seconds = experiment.case(method, folder)
            shared = {"group": experiment.group, "case": experiment.name, "method": method,
                      "spacing_m": experiment.spacing[method], "particles": len(case.run.frame(0))}
            for name, (unit, value) in measured(experiment, case).items():
                low, high = experiment.known.get(name, (np.nan, np.nan))
                off = (value / low if value < low else value / high if value > high else 1.0) - 1.0
                row = {**shared, "quantity": name, "unit": unit, "value": f"{value:.4g}",
                       "published": "" if np.isnan(low) else f"{low:.4g}" if low == high else f"{low:.4g}-{high:.4g}",
                       "off_percent": "" if np.isnan(low) else f"{100.0 * off:+.1f}",
                       "processor_s": "" if np.isnan(seconds) else f"{seconds:.0f}"}
                print(*row.values(), flush=True)
                yield row


def draw(rows, path):
    """Run-outs and heights over the aspect ratio, forces over the inclination, of the groups that were run."""
    groups = [group for group in ("plane", "round", "flume") if any(row["group"] == group for row in rows)]
    figure, axes = plt.subplots(2, len(groups), figsize=(4.0 * len(groups), 6.6), constrained_layout=True,
                                squeeze=False)
    for column, group in zip(axes.T, groups, strict=True):
        own = [row for row in rows if row["group"] == group]
        draw_flume(column, own) if group == "flume" else draw_columns(column, group, own)
        for axis in column:
            axis.grid(alpha=0.3)
        column[0].legend(fontsize=7)
    figure.savefig(path, dpi=70)


def draw_columns(axes, group, rows):
    """Run-out and height of columns over the aspect ratio, with the laws of the experiments."""
    laws = {"plane": (plane_runout, plane_height), "round": (round_runout, round_height)}[group]
    looks = {("mpm", "33"): ("C0", "o", "none"), ("mpm", "37"): ("C0", "o", "C0"), ("sph", "33"): ("C1", "s", "none"),
             ("sph", "37"): ("C1", "s", "C1")}
    a = np.linspace(0.3, 10.5 if group == "plane" else 4.5, 200)
    axes[0].plot(a, [1.0 + laws[0](one) for one in a], color="0.4", label="experiments")
    axes[1].fill_between(a, *np.transpose([laws[1](one) for one in a]), color="0.4", lw=1.5)
    for axis, quantity in zip(axes, ("run-out", "height of the middle"), strict=True):
        for (method, angle), (color, marker, face) in looks.items():
            own = [row for row in rows if (row["quantity"], row["method"]) == (quantity, method)
                   and f", {angle} deg" in row["case"]]
            ratio = [float(row["case"].split(",")[0][2:]) for row in own]
            width = [0.4 if (group, one) == ("plane", 0.5) else 0.2 for one in ratio]
            axis.plot(ratio, [float(row["value"]) / d for row, d in zip(own, width, strict=True)], marker, color=color,
                      mfc=face, label=f"{method}, {angle} degrees")
        axis.set(xlabel="height over half-width a" if group == "plane" else "height over radius a",
                 ylabel=f"{quantity} over d0", title=f"{group} columns")


def draw_flume(axes, rows):
    """Largest force and thrust at rest over the inclination, with Coulomb's wedges."""
    for method, color, marker in (("mpm", "C0", "o"), ("sph", "C1", "s")):
        for angle, face in (("35", color), ("33", "none"), ("44", "none")):
            for axis, quantity in zip(axes, ("largest force", "thrust at rest"), strict=True):
                axis.plot(*_over_inclination(rows, quantity, method, angle), marker, color=color, mfc=face,
                          label=f"{method}, {angle} degrees")
    for name in ("least", "largest"):
        axes[1].plot(*_over_inclination(rows, f"{name} thrust of wedges", "mpm", "35"), color="0.4")
    for axis, title in zip(axes, ("largest force on the wall", "thrust at rest, between wedges"),
                           strict=True):
        axis.set(xlabel="inclination of the flume [degrees]", ylabel="N", title=title)


def _over_inclination(rows, quantity, method, angle):
    own = [row for row in rows if (row["quantity"], row["method"]) == (quantity, method)
           and f"sand {angle}" in row["case"]]
    return [float(row["case"].split(" ")[0]) for row in own], [float(row["value"]) for row in own]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", nargs="*")
    parser.add_argument("--runs", type=Path)
    parser.add_argument("-o", "--output", type=Path, default=HERE / "figures")
    options = parser.parse_args()
    chosen = [one for one in experiments() if not options.only or one.group in options.only]
    with tempfile.TemporaryDirectory() as scratch:
        rows = list(table(chosen, options.runs or Path(scratch)))
    path = options.output / "granular_experiments.csv"
    if options.only and path.exists():  # what was not asked for stays
        with open(path, newline="", encoding="utf-8") as file:
            rows += [row for row in csv.DictReader(file) if row["group"] not in options.only]
    with open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, list(rows[0]))
        writer.writeheader()
        writer.writerows(rows)
    draw(rows, options.output / "granular_experiments.png")


if __name__ == "__main__":
    main()
